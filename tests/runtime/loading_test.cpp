/** The core's parts between a manifest and an engine: registry, choice of artifact, output pool, CUDA. */
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <dlfcn.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "base/cuda.h"
#include "base/library.h"
#include "base/pool.h"
#include "core/cpu.h"
#include "core/registry.h"
#include "core/select.h"
#include "core/self_test.h"
#include "core/status.h"
#include "core/threads.h"
#include "support.h"

namespace chiasm::testing {
namespace {

using core::Artifact;
using core::Isa;
using core::LoadRequest;
using core::Registry;
using ::testing::AllOf;
using ::testing::HasSubstr;

const std::string kGood = CHIASM_FAKE_FOLDER "/good", kBad = CHIASM_FAKE_FOLDER "/bad";

/** The reason why a backend cannot be used; the message for a missing backend if it is not registered. */
std::string problem(Registry& registry, const std::string& name) {
  const core::Backend* const backend = registry.find(name);
  return backend == nullptr ? "not found" : backend->engine().problem;
}

std::vector<std::string> names(Registry& registry) {
  std::vector<std::string> names;
  for (const auto& backend : registry.all()) names.push_back(backend->name());
  return names;
}

TEST(Registry, FindsWhatIsThereByPriority) {
  Registry registry({kGood});
  EXPECT_THAT(names(registry), ::testing::ElementsAre("native", "torch", "onnx"));
  const core::Backend* const native = registry.find("native");
  ASSERT_NE(native, nullptr);
  EXPECT_NE(native->table(), nullptr);
  EXPECT_EQ(native->engine().version, "fake 1.0");
  EXPECT_EQ(native->engine().problem, "");
  EXPECT_EQ(registry.find("native"), native);
}

TEST(Registry, KnowsNoNames) {
  const TemporaryFolder folder;
  const std::string plugin = folder.path() + "/libchiasm_";
  ASSERT_EQ(::symlink((kGood + "/libchiasm_native.so").c_str(), (plugin + "tensorrt.so").c_str()), 0);
  for (const char* other : {"UPPER.so", ".so", "a-b.so", "native.txt", "x.so.1"})
    std::ofstream(plugin + other) << "nothing";
  Registry registry({folder.path()});
  EXPECT_THAT(names(registry), ::testing::ElementsAre("tensorrt"));
  EXPECT_THAT(problem(registry, "tensorrt"), HasSubstr("calls itself 'native'"));
}

TEST(Registry, SaysWhereItLookedForAMissingPlugin) {
  const TemporaryFolder empty;
  Registry registry({"/nowhere", empty.path()});
  EXPECT_TRUE(registry.all().empty());
  EXPECT_EQ(registry.find("onnx"), nullptr);
  EXPECT_THAT(registry.not_found("onnx"), AllOf(HasSubstr("libchiasm_onnx.so"), HasSubstr("/nowhere"),
                                                HasSubstr(empty.path()), HasSubstr("CHIASM_BACKEND_PATH")));
}

TEST(Registry, SaysWhichEngineIsMissing) {
  Registry registry({kGood});  // whose torch lacks its engine
  EXPECT_THAT(problem(registry, "torch"),
              AllOf(HasSubstr("the torch backend is not available"), HasSubstr("libfake_engine.so"),
                    HasSubstr("cannot open shared object file")));
  EXPECT_EQ(problem(registry, "onnx"), "");
}

TEST(Registry, RefusesForeignPlugins) {
  Registry registry({kBad});
  EXPECT_THAT(problem(registry, "native"), HasSubstr("another version of chiasm"));
  EXPECT_THAT(problem(registry, "onnx"), HasSubstr("the fake engine is too old"));
  EXPECT_THAT(problem(registry, "torch"), HasSubstr("calls itself 'native'"));
  EXPECT_THAT(problem(registry, "broken"), HasSubstr("libfake_engine.so"));
}

TEST(Registry, RefusesAnIncompleteTable) {
  for (const std::string member : {"formats", "probe", "load", "run", "unload", "values of an option"}) {
    ::setenv("FAKE_LACKS", member.c_str(), 1);
    Registry registry({kGood});
    EXPECT_THAT(problem(registry, "native"),
                HasSubstr("libchiasm_native.so is incomplete: its table has no " + member));
    EXPECT_EQ(registry.find("native")->table(), nullptr);
  }
  ::unsetenv("FAKE_LACKS");
}

TEST(Registry, RefusesALibraryThatIsNoPlugin) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() + "/libchiasm_text.so") << "no library";
  Registry registry({folder.path()});
  EXPECT_THAT(problem(registry, "text"), HasSubstr("libchiasm_text.so"));
}

TEST(Registry, DoesNotWaitForAPipe) {
  const TemporaryFolder folder;
  const std::string pipe = folder.path() + "/libchiasm_pipe.so";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  Registry registry({folder.path()});
  EXPECT_THAT(problem(registry, "pipe"), HasSubstr(pipe + ": not a regular file"));
}

/** A server without free file descriptors at its first load must not keep that result. */
#ifndef __SANITIZE_ADDRESS__  // that build has UBSan, which opens a file to inspect an error
TEST(Registry, LooksAgainWhenThereAreFiles) {
  const TemporaryFolder folder;
  const std::string plugin = folder.path() + "/libchiasm_native.so";
  std::filesystem::copy(kGood + "/libchiasm_native.so", plugin);  // a plug-in that is not open
  Registry registry({folder.path()});
  const auto refusal = [](const auto& open) {
    try {
      open();
      return std::string("none");
    } catch (const core::Error& error) {
      return std::to_string(error.code()) + " " + error.what();
    }
  };
  std::string unused;
  rlimit before{};
  ::getrlimit(RLIMIT_NOFILE, &before);
  rlimit limit = before;
  limit.rlim_cur = static_cast<rlim_t>(::dup(0));  // the lowest free number
  ::close(static_cast<int>(limit.rlim_cur));
  ::setrlimit(RLIMIT_NOFILE, &limit);
  const std::string of_folder = refusal([&] { registry.all(); });
  const std::string of_plugin = refusal([&] { base::open_library(plugin.c_str(), unused); });
  ::setrlimit(RLIMIT_NOFILE, &before);
  const std::string code = std::to_string(CHIASM_IO_ERROR) + " ";
  EXPECT_EQ(of_folder, code + folder.path() + ": Too many open files");
  EXPECT_THAT(of_plugin, AllOf(HasSubstr(code + plugin), HasSubstr("Too many open files")));
  EXPECT_THAT(names(registry), ::testing::ElementsAre("native"));
  EXPECT_EQ(problem(registry, "native"), "");
}
#endif

TEST(Registry, TheFirstFolderCounts) {
  Registry registry({kBad, kGood});
  EXPECT_EQ(registry.find("native")->table(), nullptr);
}

TEST(Registry, ManyThreadsMayAsk) {
  Registry registry({kGood});
  std::vector<std::thread> threads;
  const char* const asked[] = {"native", "torch", "onnx"};
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back(
        [&registry, &asked, i] { EXPECT_EQ(problem(registry, asked[i % 3]).empty(), i % 3 != 1); });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(Registry, SplitsPaths) {
  EXPECT_THAT(core::split_path("/a::b:"), ::testing::ElementsAre("/a", "b"));
  EXPECT_TRUE(core::split_path(nullptr).empty());
}

int32_t no_rank(const core::Backend&, const Artifact&) { return 0; }

class Choice : public ::testing::Test {
 protected:
  core::Manifest manifest_ = core::parse_manifest(manifest().dump(), "m");
  const core::MethodSpec& forward_ = manifest_.methods[0];
  Registry registry_{{kGood}};

  std::string chosen(const LoadRequest& request, Isa isa = Isa::x86_64_v3, int32_t dtype = CHIASM_FLOAT32) {
    std::string file;
    core::choose(forward_, request, dtype, {isa, 0, {}}, registry_, no_rank,
                 [&](const core::Candidate& candidate) { file = candidate.artifact->file; });
    return file;
  }
  std::string refusal(const LoadRequest& request, chiasm_code code, Isa isa = Isa::x86_64_v3,
                      int32_t dtype = CHIASM_FLOAT32) {
    return testing::refusal<core::Error>(code, [&] { chosen(request, isa, dtype); });
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
  request.backend = "native";
  EXPECT_THAT(refusal(request, CHIASM_FAILED_PRECONDITION), HasSubstr("allow_native_code"));
  request.backend = "torch";
  EXPECT_THAT(refusal(request, CHIASM_FAILED_PRECONDITION), HasSubstr("allow_native_code"));
}

TEST_F(Choice, SaysWhyThereIsNoNativeCode) {
  core::MethodSpec method = forward_;
  method.artifacts.erase(method.artifacts.begin(), method.artifacts.begin() + 2);
  LoadRequest request;
  request.backend = "native";
  const auto says = [&] {
    try {
      core::choose(method, request, CHIASM_FLOAT32, {}, registry_, no_rank, [](const core::Candidate&) {});
    } catch (const core::Error& error) {
      EXPECT_EQ(error.code(), CHIASM_NOT_FOUND);
      return std::string(error.what());
    }
    return std::string("was accepted");
  };
  EXPECT_THAT(says(), HasSubstr("native: the bundle has no artifact for it"));
  Artifact package = method.artifacts[0];
  package.file = "forward.float32.pt2";
  package.backend = "torch";
  package.format = "aotinductor";
  package.needs = {"libtorch"};
  method.artifacts.push_back(package);
  EXPECT_THAT(says(), HasSubstr("native: forward.float32.pt2 needs libtorch"));
  method.artifacts.back().why = "aten.foo";
  EXPECT_THAT(says(), HasSubstr("native: forward.float32.pt2 needs libtorch: aten.foo"));
}

TEST_F(Choice, AnExplicitBackendIsNotReplaced) {
  LoadRequest request;
  request.backend = "onnx";
  EXPECT_EQ(chosen(request), "forward.float32.onnx");
  request.backend = "torch";
  EXPECT_THAT(refusal(request, CHIASM_UNAVAILABLE), HasSubstr("libfake_engine.so"));
  request.backend = "tensorrt";
  EXPECT_THAT(refusal(request, CHIASM_UNAVAILABLE), HasSubstr("libchiasm_tensorrt.so"));
  request.backend = "native";
  EXPECT_THAT(refusal(request, CHIASM_NOT_FOUND, Isa::none),
              HasSubstr("forward.v3.so needs a CPU with x86-64-v3"));
  EXPECT_THAT(refusal(request, CHIASM_NOT_FOUND, Isa::armv8_2_a),
              HasSubstr("forward.v3.so needs a CPU with x86-64-v3"));
  EXPECT_THAT(refusal(request, CHIASM_NOT_FOUND, Isa::x86_64_v3, CHIASM_FLOAT64),
              HasSubstr("is not for float64"));
}

TEST_F(Choice, CudaNeedsAnArtifactAndAnEngine) {
  LoadRequest request;
  request.device_type = CHIASM_CUDA;
  EXPECT_THAT(refusal(request, CHIASM_UNAVAILABLE),
              AllOf(HasSubstr("is for the CPU"), HasSubstr("cannot use CUDA here")));
}

TEST_F(Choice, CodeForANewerCLibraryIsLeftOut) {
  Artifact artifact;
  artifact.glibc = {2, 36};
  const auto why = [&](int major, int minor) {
    return core::incompatibility(artifact, {}, core::kGeneric, {Isa::none, 0, {major, minor}});
  };
  EXPECT_EQ(why(2, 36), "");
  EXPECT_EQ(why(3, 0), "");
  EXPECT_EQ(why(2, 35), "needs glibc 2.36, this machine has 2.35");
  EXPECT_EQ(why(0, 0), "needs glibc 2.36, this machine has another C library");
}

TEST(Cpu, RunsCodeForItsOwnFamilyUpToItsLevel) {
  EXPECT_TRUE(core::has(Isa::none, Isa::none));
  EXPECT_TRUE(core::has(Isa::x86_64_v4, Isa::x86_64_v3));
  EXPECT_FALSE(core::has(Isa::x86_64_v3, Isa::x86_64_v4));
  EXPECT_TRUE(core::has(Isa::x86_64_v3, Isa::x86_64_v2));
  EXPECT_FALSE(core::has(Isa::x86_64_v2, Isa::x86_64_v3));
  EXPECT_FALSE(core::has(Isa::armv8_2_a, Isa::x86_64_v2));
  EXPECT_TRUE(core::has(Isa::armv8_2_a, Isa::armv8_2_a));
  EXPECT_TRUE(core::has(Isa::armv8_2_a, Isa::none));
  EXPECT_FALSE(core::has(Isa::armv8_2_a, Isa::x86_64_v3));
  EXPECT_FALSE(core::has(Isa::x86_64_v4, Isa::armv8_2_a));
  EXPECT_FALSE(core::has(Isa::none, Isa::armv8_2_a));
}

TEST_F(Choice, GoesOnWhereABackendCannotLoadIt) {
  std::vector<std::string> tried;
  const auto choose = [&](chiasm_code code) {
    core::choose(forward_, {}, CHIASM_FLOAT32, {Isa::x86_64_v4, 0, {}}, registry_, no_rank,
                 [&](const core::Candidate& candidate) {
                   tried.push_back(candidate.artifact->file);
                   if (candidate.backend->name() == "native") throw core::Error(code, "an old interface");
                 });
  };
  choose(CHIASM_VERSION_MISMATCH);
  EXPECT_THAT(tried, ::testing::ElementsAre("forward.v4.so", "forward.v3.so", "forward.float32.onnx"));
  EXPECT_THROW(choose(CHIASM_CORRUPT), core::Error);  // damage is reported, not skipped
}

TEST_F(Choice, ARankPutsOneBeforeAnotherOrLeavesItOut) {
  const auto chosen = [&](const core::Rank& rank) {
    std::string file;
    core::choose(forward_, {}, CHIASM_FLOAT32, {Isa::x86_64_v4, 0, {}}, registry_, rank,
                 [&](const core::Candidate& candidate) { file = candidate.artifact->file; });
    return file;
  };
  EXPECT_EQ(chosen([](const core::Backend&, const Artifact& a) { return a.isa == Isa::x86_64_v3 ? 1 : 0; }),
            "forward.v3.so");
  EXPECT_EQ(chosen([](const core::Backend& b, const Artifact&) { return b.name() == "native" ? -1 : 0; }),
            "forward.float32.onnx");
}

TEST_F(Choice, GpuCodeRunsOnItsMajorVersion) {
  Artifact artifact;
  artifact.device = core::DevicePlacement::cuda;
  LoadRequest request;
  EXPECT_EQ(core::incompatibility(artifact, request, core::kGeneric, {}), "is for CUDA");
  request.device_type = CHIASM_CUDA;
  artifact.sm = 86;
  EXPECT_EQ(core::incompatibility(artifact, request, core::kGeneric, {Isa::none, 86, {}}), "");
  EXPECT_EQ(core::incompatibility(artifact, request, core::kGeneric, {Isa::none, 89, {}}), "");
  EXPECT_NE(core::incompatibility(artifact, request, core::kGeneric, {Isa::none, 80, {}}), "");
  EXPECT_NE(core::incompatibility(artifact, request, core::kGeneric, {Isa::none, 90, {}}), "");
}

TEST_F(Choice, DtypeDefaultsToFloat32OrWhatThereIs) {
  const auto dtype = [this](const LoadRequest& request) {
    return core::choose_dtype(forward_, manifest_.dtypes, request);
  };
  LoadRequest request;
  EXPECT_EQ(dtype(request), CHIASM_FLOAT32);
  request.dtype = CHIASM_FLOAT64;
  EXPECT_EQ(dtype(request), CHIASM_FLOAT64);
  request.dtype = CHIASM_INT8;
  EXPECT_THROW(dtype(request), core::Error);
  request.dtype = CHIASM_FLOAT64;
  request.backend = "native";
  EXPECT_THROW(dtype(request), core::Error);
  core::MethodSpec wide = forward_;
  wide.artifacts.erase(wide.artifacts.begin(), wide.artifacts.begin() + 4);  // leaves forward.float64.onnx
  EXPECT_EQ(core::choose_dtype(wide, manifest_.dtypes, {}), CHIASM_FLOAT64);
}

TEST(DTypes, TheTableAgreesWithItself) {
  for (int32_t dtype = 0; dtype < base::kDTypeCount; ++dtype) {
    EXPECT_EQ(base::dtype_from_name(base::kDTypes[dtype].name), dtype);
    EXPECT_EQ(base::dtype_from_safetensors(base::kDTypes[dtype].safetensors), dtype);
    EXPECT_STREQ(name(static_cast<DType>(dtype)), base::kDTypes[dtype].name);
    const std::string text = base::kDTypes[dtype].name;
    if (dtype != CHIASM_BOOL) {
      EXPECT_EQ(std::stoul(text.substr(text.find_first_of("0123456789"))), 8 * base::kDTypes[dtype].size);
    }
  }
  EXPECT_EQ(dtype_of<uint16_t>, DType::UInt16);
  EXPECT_EQ(base::dtype_from_name("uint32"), -1);
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
  const std::vector<Isa> isas = core::supported_isas();
  EXPECT_TRUE(std::is_sorted(isas.begin(), isas.end()));
  EXPECT_EQ(core::this_machine(CHIASM_CPU, 0).isa, isas.empty() ? Isa::none : isas.back());
}

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kPoolCaches = false;
#else
constexpr bool kPoolCaches = true;
#endif

TEST(Pool, BlocksAreAlignedAndReused) {
  base::Pool pool;
  for (const size_t size : {size_t{0}, size_t{1}, size_t{1000}, size_t{1} << 20}) {
    void* const block = pool.allocate(size);
    EXPECT_NE(block, nullptr);
    EXPECT_EQ(reinterpret_cast<uintptr_t>(block) % 64, 0u);
    pool.release(block, size);
  }
  EXPECT_EQ(pool.allocate(~size_t{0}), nullptr);
  if (!kPoolCaches) GTEST_SKIP() << "the pool keeps nothing under AddressSanitizer";
  void* const big = pool.allocate(1 << 20);
  pool.release(big, 1 << 20);
  void* const again = pool.allocate((1 << 20) - 5000);
  EXPECT_EQ(again, big);
  pool.release(again, (1 << 20) - 5000);
  pool.trim();
}

TEST(Pool, KeepsOnlySoMuch) {
  base::Pool pool;
  const size_t size = size_t{16} << 20;
  std::vector<void*> blocks;
  for (int i = 0; i < 50; ++i) blocks.push_back(pool.allocate(size));
  for (void* const block : blocks) pool.release(block, size);
  EXPECT_LE(pool.kept_bytes(), size_t{256} << 20);
  // A block much larger than the request is kept for larger requests.
  const size_t before = pool.kept_bytes();
  void* const small = pool.allocate(size_t{1} << 20);
  EXPECT_EQ(pool.kept_bytes(), before);
  pool.release(small, size_t{1} << 20);
  pool.trim();
  EXPECT_EQ(pool.kept_bytes(), 0u);
}

/** With a driver of which the test says what fails. It is opened first, and so is found for the real one. */
class CudaErrors : public ::testing::Test {
 protected:
  static constexpr int kOutOfMemory = 2, kNoDevice = 100, kIllegalAddress = 700;  // CUresult

  void SetUp() override {
    void* const driver = ::dlopen(CHIASM_FAKE_CUDA, RTLD_NOW | RTLD_LOCAL);
    ASSERT_NE(driver, nullptr) << ::dlerror();
    fail_in_ = reinterpret_cast<void (*)(const char*, int)>(::dlsym(driver, "fake_cuda_fail"));
    ASSERT_NE(fail_in_, nullptr);
  }

  void (*fail_in_)(const char* function, int result) = nullptr;
};

TEST_F(CudaErrors, TellAMissingDeviceFromAFailedCall) {
  const auto code = [&](const char* function, int result) {
    fail_in_(function, result);
    try {
      char bytes[16] = {};
      base::CudaBuffer buffer(0, sizeof bytes);
      buffer.copy_from_host(bytes, sizeof bytes);
      buffer.copy_to_host(bytes, sizeof bytes);
    } catch (const core::Error& error) {
      return error.code();
    }
    return CHIASM_OK;
  };
  EXPECT_EQ(code("", 0), CHIASM_OK);
  for (const char* function : {"cuInit", "cuDeviceGetCount", "cuDeviceGet", "cuDevicePrimaryCtxRetain"})
    EXPECT_EQ(code(function, kNoDevice), CHIASM_UNAVAILABLE) << function;
  for (const char* function :
       {"cuCtxPushCurrent_v2", "cuMemAlloc_v2", "cuMemcpyHtoD_v2", "cuCtxSynchronize", "cuMemcpyDtoH_v2"})
    EXPECT_EQ(code(function, kIllegalAddress), CHIASM_INTERNAL) << function;
  for (const char* function : {"cuDevicePrimaryCtxRetain", "cuMemAlloc_v2"})
    EXPECT_EQ(code(function, kOutOfMemory), CHIASM_OUT_OF_MEMORY) << function;
}

TEST_F(CudaErrors, FailTheSelfTest) {
  const TemporaryFolder folder;
  const auto bundle = std::make_shared<const core::Bundle>(write_bundle(folder).c_str(), core::get_trust());
  Registry registry({kGood});
  LoadRequest request;
  request.backend = "onnx";
  request.device_type = CHIASM_CUDA;
  const auto passed = [&](const char* function, int result) {
    fail_in_(function, result);
    std::vector<int32_t> rows;
    core::self_test(
        bundle, request, registry,
        [](const chiasm_self_test_row* row, void* all) {
          static_cast<std::vector<int32_t>*>(all)->push_back(row->passed);
        },
        &rows);
    return rows;
  };
  EXPECT_THAT(passed("", 0), ::testing::ElementsAre(1));
  EXPECT_THAT(passed("cuCtxSynchronize", kIllegalAddress), ::testing::ElementsAre(0));
  EXPECT_THAT(passed("cuMemAlloc_v2", kOutOfMemory), ::testing::ElementsAre(0));
}

}  // namespace
}  // namespace chiasm::testing
