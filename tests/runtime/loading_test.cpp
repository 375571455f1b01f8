/** The core's insides between a manifest and an engine: registry, artifact choice, output pool. */
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "core/cpu.h"
#include "core/pool.h"
#include "core/registry.h"
#include "core/select.h"
#include "core/status.h"
#include "core/threads.h"
#include "support.h"

namespace chiasm::testing {
namespace {

using core::Artifact;
using core::BackendKind;
using core::Isa;
using core::LoadRequest;
using core::Registry;
using ::testing::AllOf;
using ::testing::HasSubstr;

const std::string kGood = CHIASM_FAKE_FOLDER "/good", kBad = CHIASM_FAKE_FOLDER "/bad";

TEST(Registry, OpensWhatIsThere) {
  Registry registry({kGood});
  const core::Backend& native = registry.get(BackendKind::native);
  EXPECT_NE(native.table, nullptr);
  EXPECT_EQ(native.engine_version, "fake 1.0");
  EXPECT_EQ(native.problem, "");
  EXPECT_EQ(&registry.get(BackendKind::native), &native);
}

TEST(Registry, SaysWhereItLookedForAMissingPlugin) {
  const TemporaryFolder empty;
  Registry registry({"/nowhere", empty.path()});
  const core::Backend& onnx = registry.get(BackendKind::onnx);
  EXPECT_EQ(onnx.table, nullptr);
  EXPECT_THAT(onnx.problem, AllOf(HasSubstr("the onnx backend is not available"), HasSubstr("libchiasm_onnx.so"), HasSubstr("/nowhere"),
                                  HasSubstr(empty.path()), HasSubstr("pip install onnxruntime")));
  EXPECT_THAT(registry.get(BackendKind::torch).problem, HasSubstr("pip install torch"));
  EXPECT_THAT(Registry({}).get(BackendKind::native).problem, HasSubstr("CHIASM_BACKEND_PATH"));
}

TEST(Registry, SaysWhichEngineLibraryIsMissing) {
  Registry registry({kGood});  // its torch needs a library that is nowhere
  EXPECT_THAT(registry.get(BackendKind::torch).problem,
              AllOf(HasSubstr("libfake_engine.so"), HasSubstr("cannot open shared object file"), HasSubstr("pip install torch")));
  EXPECT_NE(registry.get(BackendKind::onnx).table, nullptr);
}

TEST(Registry, RefusesForeignPlugins) {
  Registry registry({kBad});
  EXPECT_THAT(registry.get(BackendKind::native).problem, HasSubstr("another version of chiasm"));
  EXPECT_THAT(registry.get(BackendKind::onnx).problem, HasSubstr("the fake engine is too old"));
  EXPECT_THAT(registry.get(BackendKind::torch).problem, HasSubstr("calls itself 'native'"));
}

TEST(Registry, TheFirstFolderCounts) {
  Registry registry({kBad, kGood});
  EXPECT_EQ(registry.get(BackendKind::native).table, nullptr);
}

TEST(Registry, ManyThreadsMayAsk) {
  Registry registry({kGood});
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&registry, i] { EXPECT_EQ(registry.get(static_cast<BackendKind>(i % 3)).table != nullptr, i % 3 != 1); });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(Registry, SplitsPaths) {
  EXPECT_THAT(core::split_path("/a::b:"), ::testing::ElementsAre("/a", "b"));
  EXPECT_TRUE(core::split_path(nullptr).empty());
}

class Choice : public ::testing::Test {
 protected:
  core::Manifest manifest_ = core::parse_manifest(manifest().dump(), "m");
  const core::MethodSpec& forward_ = manifest_.methods[0];
  Registry registry_{{kGood}};

  std::string chosen(const LoadRequest& request, Isa isa = Isa::x86_64_v3, int32_t dtype = CHIASM_FLOAT32) {
    return core::choose(forward_, request, dtype, {isa, 0}, registry_).artifact->file;
  }
  std::string refusal(const LoadRequest& request, chiasm_code code, Isa isa = Isa::x86_64_v3, int32_t dtype = CHIASM_FLOAT32) {
    try {
      chosen(request, isa, dtype);
    } catch (const core::Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      return error.what();
    }
    ADD_FAILURE() << "was accepted";
    return "";
  }
};

TEST_F(Choice, AutoPrefersNativeForTheBestIsa) {
  EXPECT_EQ(chosen({}), "forward.v3.so");
  EXPECT_EQ(chosen({}, Isa::x86_64_v4), "forward.v4.so");
}

TEST_F(Choice, AutoGoesOnWhereNativeCannot) {
  EXPECT_EQ(chosen({}, Isa::none), "forward.float32.onnx");  // the fake torch is broken
  EXPECT_EQ(chosen({}, Isa::x86_64_v4, CHIASM_FLOAT64), "forward.float64.onnx");
}

TEST_F(Choice, WithoutNativeCodeOnlyOnnxIsLeft) {
  LoadRequest request;
  request.allow_native_code = false;
  EXPECT_EQ(chosen(request), "forward.float32.onnx");
  request.backend = BackendKind::native;
  EXPECT_THAT(refusal(request, CHIASM_FAILED_PRECONDITION), HasSubstr("allow_native_code"));
  request.backend = BackendKind::torch;
  EXPECT_THAT(refusal(request, CHIASM_FAILED_PRECONDITION), HasSubstr("allow_native_code"));
}

TEST_F(Choice, SaysWhyThereIsNoNativeCode) {
  core::MethodSpec method = forward_;
  method.artifacts.erase(method.artifacts.begin(), method.artifacts.begin() + 2);
  LoadRequest request;
  request.backend = BackendKind::native;
  const auto says = [&] {
    try {
      core::choose(method, request, CHIASM_FLOAT32, {}, registry_);
    } catch (const core::Error& error) {
      EXPECT_EQ(error.code(), CHIASM_NOT_FOUND);
      return std::string(error.what());
    }
    return std::string("was accepted");
  };
  EXPECT_THAT(says(), HasSubstr("native: the bundle has no artifact for it"));
  Artifact package = method.artifacts[0];
  package.file = "forward.float32.pt2";
  package.needs_libtorch = true;
  method.artifacts.push_back(package);
  EXPECT_THAT(says(), HasSubstr("native: forward.float32.pt2 needs libtorch"));
  method.artifacts.back().why = "aten.foo";
  EXPECT_THAT(says(), HasSubstr("native: forward.float32.pt2 needs libtorch: aten.foo"));
}

TEST_F(Choice, AnExplicitBackendIsNotReplaced) {
  LoadRequest request;
  request.backend = BackendKind::onnx;
  EXPECT_EQ(chosen(request), "forward.float32.onnx");
  request.backend = BackendKind::torch;
  EXPECT_THAT(refusal(request, CHIASM_UNAVAILABLE), HasSubstr("libfake_engine.so"));
  request.backend = BackendKind::native;
  EXPECT_THAT(refusal(request, CHIASM_NOT_FOUND, Isa::none), HasSubstr("forward.v3.so needs a CPU with x86-64-v3"));
  EXPECT_THAT(refusal(request, CHIASM_NOT_FOUND, Isa::x86_64_v3, CHIASM_FLOAT64), HasSubstr("is not for float64"));
}

TEST_F(Choice, CudaNeedsAnArtifactAndAnEngine) {
  LoadRequest request;
  request.device_type = CHIASM_CUDA;
  EXPECT_THAT(refusal(request, CHIASM_UNAVAILABLE), AllOf(HasSubstr("is for the CPU"), HasSubstr("cannot use CUDA here")));
}

TEST_F(Choice, GpuCodeRunsOnItsMajorVersion) {
  Artifact artifact;
  artifact.device = core::DevicePlacement::cuda;
  LoadRequest request;
  EXPECT_EQ(core::misfit(artifact, request, core::kGeneric, {}), "is for CUDA");
  request.device_type = CHIASM_CUDA;
  artifact.sm = 86;
  EXPECT_EQ(core::misfit(artifact, request, core::kGeneric, {Isa::none, 86}), "");
  EXPECT_EQ(core::misfit(artifact, request, core::kGeneric, {Isa::none, 89}), "");
  EXPECT_NE(core::misfit(artifact, request, core::kGeneric, {Isa::none, 80}), "");
  EXPECT_NE(core::misfit(artifact, request, core::kGeneric, {Isa::none, 90}), "");
}

TEST_F(Choice, DtypeDefaultsToFloat32OrWhatThereIs) {
  const auto dtype = [this](const LoadRequest& request) { return core::choose_dtype(forward_, manifest_.dtypes, request); };
  LoadRequest request;
  EXPECT_EQ(dtype(request), CHIASM_FLOAT32);
  request.dtype = CHIASM_FLOAT64;
  EXPECT_EQ(dtype(request), CHIASM_FLOAT64);
  request.dtype = CHIASM_INT8;
  EXPECT_THROW(dtype(request), core::Error);
  request.dtype = CHIASM_FLOAT64;
  request.backend = BackendKind::native;
  EXPECT_THROW(dtype(request), core::Error);
  core::MethodSpec wide = forward_;
  wide.artifacts.erase(wide.artifacts.begin(), wide.artifacts.begin() + 4);  // leaves forward.float64.onnx
  EXPECT_EQ(core::choose_dtype(wide, manifest_.dtypes, {}), CHIASM_FLOAT64);
}

TEST(Threads, ZeroMeansTheCoresOfThisProcess) {
  const int32_t cores = core::get_num_threads();
  EXPECT_GT(cores, 0);
  core::set_num_threads(3);
  EXPECT_EQ(core::get_num_threads(), 3);
  core::set_num_threads(0);
  EXPECT_EQ(core::get_num_threads(), cores);
  EXPECT_THROW(core::set_num_threads(-1), core::Error);
  EXPECT_THROW(core::set_num_threads(1 << 20), core::Error);
  EXPECT_EQ(core::use_num_threads(), cores);
  EXPECT_THROW(core::set_num_threads(1), core::Error);
}

TEST(Cpu, V4ImpliesV3) {
  EXPECT_TRUE(core::cpu_supports(Isa::none));
  EXPECT_TRUE(!core::cpu_supports(Isa::x86_64_v4) || core::cpu_supports(Isa::x86_64_v3));
}

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kPoolCaches = false;
#else
constexpr bool kPoolCaches = true;
#endif

TEST(Pool, BlocksAreAlignedAndReused) {
  core::BufferPool pool;
  for (const size_t size : {size_t{0}, size_t{1}, size_t{1000}, size_t{1} << 20}) {
    const auto block = pool.take(size);
    EXPECT_EQ(reinterpret_cast<uintptr_t>(block.data) % 64, 0u);
    EXPECT_GE(block.capacity, size);
    pool.give(block);
  }
  if (!kPoolCaches) GTEST_SKIP() << "the pool keeps nothing under AddressSanitizer";
  const auto big = pool.take(1 << 20);
  pool.give(big);
  const auto again = pool.take((1 << 20) - 5000);
  EXPECT_EQ(again.data, big.data);
  pool.give(again);
}

TEST(Pool, KeepsOnlySoMuch) {
  core::BufferPool pool;
  std::vector<core::BufferPool::Block> blocks;
  for (int i = 0; i < 50; ++i) blocks.push_back(pool.take(size_t{16} << 20));
  for (const auto& block : blocks) pool.give(block);
  EXPECT_LE(pool.cached_bytes(), size_t{256} << 20);
  // A block much larger than what is asked for is left for those who need it.
  const size_t before = pool.cached_bytes();
  const auto small = pool.take(size_t{1} << 20);
  EXPECT_EQ(pool.cached_bytes(), before);
  pool.give(small);
}

}  // namespace
}  // namespace chiasm::testing
