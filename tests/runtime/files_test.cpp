/** A bundle's files: the folder's content, links, errors of the system, memory, ONNX with external data. */
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "backends/onnx/onnx_file.h"
#include "chiasm/chiasm.hpp"
#include "core/file.h"
#include "core/status.h"
#include "support.h"

// These tests request more memory than can exist.
extern "C" __attribute__((visibility("default"))) const char* __asan_default_options() {
  return "allocator_may_return_null=1";
}
extern "C" __attribute__((visibility("default"))) const char* __tsan_default_options() {
  return "allocator_may_return_null=1";
}

namespace chiasm::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

class Files : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string path_ = write_bundle(folder_);
  const std::string artifact_ = path_ + "/forward.float32.onnx";

  Method load() const { return Bundle::open(path_).method("forward", LoadOptions().with_backend("onnx")); }
  std::string refused(chiasm_code code = CHIASM_CORRUPT) {
    return refusal(code, [&] { load(); });
  }
};

TEST_F(Files, WhatTheManifestDoesNotNameIsRefused) {
  EXPECT_EQ(load().backend(), "onnx");
  for (const char* name : {"evil.so", ".hidden", "manifest.json~", "a\nb\x1b"}) {
    write_text(path_ + "/" + name, "x");
    EXPECT_THAT(refused(), AllOf(HasSubstr("which its manifest does not name"), HasSubstr(path_),
                                 ::testing::Not(HasSubstr("\x1b"))));
    fs::remove(path_ + "/" + name);
  }
  fs::create_directory(path_ + "/more");
  EXPECT_THAT(refused(), HasSubstr("has 'more', which its manifest does not name: remove it"));
  fs::remove(path_ + "/more");
  fs::create_symlink("/etc/passwd", path_ + "/more");
  EXPECT_THAT(refused(), HasSubstr("has 'more'"));
}

TEST_F(Files, LinksWithinTheFolderAreFollowed) {
  fs::rename(artifact_, path_ + "/forward.pt");  // another name than in the manifest
  for (const std::string& target :
       {std::string("forward.pt"), path_ + "/forward.pt", std::string("../test.scale.chiasm/forward.pt")}) {
    fs::remove(artifact_);
    fs::create_symlink(target, artifact_);
    EXPECT_EQ(load().artifact(), "forward.float32.onnx") << target;
  }
}

TEST_F(Files, LinksThatLeaveTheFolderAreRefused) {
  const std::string outside = folder_.write("outside", artifact_content(artifact_, "scale 2"));
  fs::create_directory(path_ + "-more");  // a sibling whose name begins with the folder's name
  write_text(path_ + "-more/f", artifact_content(artifact_, "scale 2"));
  for (const std::string& target : {std::string("../outside"), outside,
                                    std::string("../test.scale.chiasm-more/f"), std::string("/dev/zero")}) {
    fs::remove(artifact_);
    fs::create_symlink(target, artifact_);
    EXPECT_THAT(refused(), HasSubstr("is a link that leaves the bundle's folder")) << target;
  }
  fs::remove(artifact_);
  fs::create_symlink("nothing", artifact_);
  refused(CHIASM_NOT_FOUND);
  fs::remove(artifact_);
  fs::create_symlink("forward.float32.onnx", artifact_);
  EXPECT_THAT(refused(CHIASM_IO_ERROR), HasSubstr("Too many levels of symbolic links"));
}

TEST_F(Files, ManifestAndSignatureAreNoLinksOutsideEither) {
  fs::copy(path_ + "/manifest.json", folder_.path() + "/manifest.json");
  fs::remove(path_ + "/manifest.json");
  fs::create_symlink("../manifest.json", path_ + "/manifest.json");
  EXPECT_THAT(refused(), HasSubstr("manifest.json: is a link that leaves"));
  fs::remove(path_ + "/manifest.json");
  fs::copy(folder_.path() + "/manifest.json", path_ + "/manifest.json");
  fs::create_symlink("../manifest.json", path_ + "/manifest.json.minisig");
  EXPECT_THAT(refused(), HasSubstr("manifest.json.minisig: is a link that leaves"));
}

TEST_F(Files, TheFolderItselfMayBeALink) {
  const std::string link = folder_.path() + "/link";
  fs::create_symlink(path_, link);
  EXPECT_EQ(Bundle::open(link).method("forward").backend(), "native");
  EXPECT_EQ(Bundle::open(link + "/").method("forward").backend(), "native");
}

TEST_F(Files, APipeDoesNotHang) {
  fs::remove(artifact_);
  ASSERT_EQ(::mkfifo(artifact_.c_str(), 0600), 0);
  EXPECT_THAT(refused(), HasSubstr("not a regular file"));
}

TEST_F(Files, TooManyOpenFilesAreNoDamage) {
  load();  // so that the backend is loaded
  rlimit old{};
  ::getrlimit(RLIMIT_NOFILE, &old);
  const int next = ::dup(0);
  ::close(next);
  const chiasm_api& api = *chiasm_get_api(CHIASM_API_VERSION);
  // Nothing else is done without free descriptors: UBSan needs some to inspect an exception.
  const auto with_limit = [&](int more, const auto& call) {
    const rlimit low{static_cast<rlim_t>(next + more), old.rlim_max};
    ::setrlimit(RLIMIT_NOFILE, &low);
    chiasm_status* const status = call();
    ::setrlimit(RLIMIT_NOFILE, &old);
    return refusal(CHIASM_IO_ERROR, [status] { detail::check(status); });
  };
  chiasm_bundle* bundle = nullptr;
  chiasm_method* method = nullptr;
  const auto open = [&] { return api.bundle_open(path_.c_str(), &bundle); };
  EXPECT_THAT(with_limit(0, open),
              AllOf(HasSubstr(path_), HasSubstr("Too many open files"), HasSubstr("ulimit -n")));
  EXPECT_THAT(with_limit(1, open), HasSubstr("manifest.json: Too many open files"));
  const Bundle good = Bundle::open(path_);
  EXPECT_THAT(with_limit(1, [&] { return api.method_load(good.c_handle(), "forward", nullptr, &method); }),
              HasSubstr("Too many open files"));
  EXPECT_EQ(good.method("forward").backend(), "native");
}

TEST_F(Files, NoPermissionIsNoDamage) {
  ::chmod(artifact_.c_str(), 0);
  ::chmod(folder_.path().c_str(), 0755);
  const bool is_root = ::geteuid() == 0;
  ASSERT_TRUE(!is_root || ::seteuid(65534) == 0);
  const std::string message = refused(CHIASM_IO_ERROR);
  ASSERT_TRUE(!is_root || ::seteuid(0) == 0);
  EXPECT_THAT(message, AllOf(HasSubstr(artifact_), HasSubstr("Permission denied"),
                             HasSubstr("must be allowed to read it")));
}

TEST_F(Files, MemoryThatIsNotThereIsNamed) {
  write_bundle(folder_, [](Json& m) {
    m["methods"]["forward"]["outputs"][1]["shape"] = {"B", "H*1099511627776*1000"};
  });
  std::vector<float> image(27), sigma(2);
  const Method method = Bundle::open(path_).method("forward");
  EXPECT_EQ(
      refusal(CHIASM_OUT_OF_MEMORY,
              [&] {
                method.run({Tensor(image.data(), {1, 3, 3, 3}), Tensor(sigma.data(), {1, 2})});
              }),
      "output 'half': out of memory: it needs 13194139533312000 bytes, its shape is (1, 3298534883328000)");
  EXPECT_THAT(
      refusal(CHIASM_OUT_OF_MEMORY,
              [&] { Bundle::open(path_).method("forward", LoadOptions().with_warm_up()); }),
      HasSubstr("the warm-up of 'forward': out of memory: a tensor of it needs 13194139533312000 bytes"));
  EXPECT_THAT(refusal<core::Error>(CHIASM_OUT_OF_MEMORY, [] { core::make_bytes(UINT64_MAX, "x"); }),
              HasSubstr("x: out of memory: it needs 18446744073709551615 bytes"));
}

TEST(Status, OutOfMemoryHasItsOwnCode) {
  for (const auto& thrown : {+[] { throw std::bad_alloc(); }, +[] { throw std::length_error("vector"); }}) {
    chiasm_status* const status = core::guarded(thrown);
    EXPECT_EQ(core::status_code(status), CHIASM_OUT_OF_MEMORY);
    EXPECT_STREQ(core::status_message(status), "out of memory");
    core::status_free(status);
  }
}

// ONNX. A message of protobuf is a list of (number, bytes).

std::string varint(uint64_t value) {
  std::string bytes;
  for (; value > 127; value >>= 7) bytes += static_cast<char>(value | 128);
  return bytes + static_cast<char>(value);
}

std::string field(uint64_t number, const std::string& content) {
  return varint(number << 3 | 2) + varint(content.size()) + content;
}
std::string field(uint64_t number, uint64_t value) { return varint(number << 3) + varint(value); }

std::string check(const std::string& model) {
  try {
    onnx::check_onnx(reinterpret_cast<const unsigned char*>(model.data()), model.size(), "m");
    return "good";
  } catch (const core::Error& error) {
    EXPECT_EQ(error.code(), CHIASM_CORRUPT);
    return error.what();
  }
}

const std::string kHere = field(1, 4) + field(2, 1) + field(8, "weights") + field(9, "1234") + field(14, 0);

/** Models with a tensor at every place that ONNX's format allows. */
std::vector<std::string> models_with(const std::string& tensor) {
  const std::string sparse = field(1, tensor), in_attribute = field(5, field(1, "value") + field(5, tensor));
  const std::string graph = field(5, tensor), node = field(4, "Constant") + in_attribute;
  const auto nested = [](const std::string& inner) { return field(1, field(5, field(6, inner))); };
  return {field(7, graph),                                  // an initializer
          field(7, field(15, sparse)),                      // a sparse one, its values
          field(7, field(15, field(2, tensor))),            // and its indices
          field(7, field(1, node)),                         // a constant
          field(7, field(1, field(5, field(10, tensor)))),  // of an attribute's list
          field(7, field(1, field(5, field(22, sparse)))),
          field(7, field(1, field(5, field(23, sparse)))),
          field(7, nested(graph)),  // in a subgraph
          field(7, nested(nested(nested(field(1, node))))),
          field(7, field(1, field(5, field(11, graph)))),  // in one of several
          field(25, field(1, "f") + field(7, node)),       // in a function
          field(25, field(11, field(5, tensor))),          // as the default of its attribute
          field(20, field(1, graph)),
          field(20, field(2, graph)),                                         // for training
          field(8, "x") + field(7, "") + field(7, field(5, kHere) + graph)};  // in the second of two graphs
}

TEST(Onnx, WithItsDataInsideIsTaken) {
  EXPECT_EQ(check(""), "good");
  for (const std::string& model : models_with(kHere)) EXPECT_EQ(check(model), "good");
  // The same field numbers have other meanings elsewhere.
  EXPECT_EQ(check(field(13, "x") + field(14, "operators")), "good");
  EXPECT_EQ(check(field(7, field(13, "x") + field(14, "annotations"))), "good");
}

TEST(Onnx, WithDataElsewhereIsRefused) {
  const std::string place = field(13, field(1, "location") + field(2, "/etc/passwd"));
  for (const std::string& tensor :
       {kHere + place, kHere + field(14, 1), kHere + field(14, (uint64_t{1} << 32) + 1),
        kHere + field(13, ""), place + kHere}) {
    for (const std::string& model : models_with(tensor))
      EXPECT_THAT(check(model), HasSubstr("m: keeps data of a tensor in another file"));
  }
}

TEST(Onnx, FunctionsThatCallEachOtherAreRefused) {
  const auto function = [](const std::string& name, const std::string& called) {
    return field(25, field(1, name) + field(7, field(4, called)));
  };
  EXPECT_EQ(check(function("f", "Relu") + field(7, field(1, field(4, "f")))), "good");
  EXPECT_THAT(check(function("f", "g") + field(7, "") + function("g", "Relu")),
              HasSubstr("m: has more than one function"));
}

TEST(Onnx, WhatIsNoProtobufIsRefused) {
  const std::string group = {'\x3b', '\x3c'};
  for (const std::string& model :
       {std::string("\x3a"), std::string("\x3a\x05xx"),
        std::string("\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01"), std::string("\x00", 1),
        std::string("\x02\x00", 2), std::string("\x0e"), group,
        std::string("\x09"
                    "1234567"),
        std::string("\x0d"
                    "123"),
        varint((uint64_t{7} << 3 | 2) + (uint64_t{1} << 32)) + varint(0),
        field(7, std::string("\x2a\x7f", 2))}) {
    EXPECT_EQ(check(model), "m: not an ONNX model: its bytes are damaged") << ::testing::PrintToString(model);
  }
  EXPECT_THAT(check(std::string("\x18\0\0\0ORTM....", 12)), HasSubstr("ONNX Runtime's own format"));
}

TEST(Onnx, DepthIsBounded) {
  std::string graph;
  for (int i = 0; i < 30; ++i) graph = field(1, field(5, field(6, graph)));
  EXPECT_EQ(check(field(7, graph)), "good");
  for (int i = 0; i < 3000; ++i) graph = field(1, field(5, field(6, graph)));
  EXPECT_EQ(check(field(7, graph)), "m: not an ONNX model: nested deeper than 100 levels");
}

TEST_F(Files, OnnxWithDataElsewhereReachesNoEngine) {
  const std::string model = field(7, field(5, field(13, field(1, "location") + field(2, "weights.bin"))));
  Json root = Json::parse(read_text(path_ + "/manifest.json"));
  root["methods"]["forward"]["artifacts"][3]["size"] = model.size();
  root["methods"]["forward"]["artifacts"][3]["sha256"] = sha256_of(model);
  write_text(path_ + "/manifest.json", root.dump());
  write_text(artifact_, model);
  EXPECT_EQ(refused(), "loading " + artifact_ +
                           " on the onnx backend failed: the model: keeps data of a tensor in another file, "
                           "which no hash covers: export it "
                           "with its data inside");
}

}  // namespace
}  // namespace chiasm::testing
