/** The backend of docs/howto/backend.md, as seen by a program that only installs it. */
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "support.h"

namespace chiasm::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Json = nlohmann::json;

class ExampleBackend : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { ::setenv("CHIASM_BACKEND_PATH", CHIASM_BACKEND_FOLDER, 1); }

  /** Writes a bundle whose only artifact is this program of the toy engine. */
  std::string write(const std::string& program, const std::string& format = "toy") const {
    std::string path = folder_.path() + "/test.scale.chiasm";
    std::filesystem::create_directory(path);
    const Json image = {{"name", "input"}, {"dtype", "float32"}, {"shape", {"N"}},  {"description", ""},
                        {"layout", ""},    {"color", ""},        {"range", nullptr}};
    Json result = image;
    result["name"] = "output";
    const std::string golden = safetensors({{"case/input", {2}, {1, 2}}, {"case/output", {2}, {3, 5}}});
    const auto file = [](const std::string& name, const std::string& content) {
      return Json{{"file", name}, {"size", content.size()}, {"sha256", sha256_of(content)}};
    };
    Json artifact = file("forward.toy", program);
    artifact.update(
        {{"backend", "example"}, {"format", format}, {"dtypes", Json::array()}, {"device", "cpu"}});
    Json root = manifest();
    root["schema_version"] = 3;
    root["dtypes"] = Json::array();
    root["symbols"] = {{"N", {{"min", 1}, {"max", 1000}}}};
    root["methods"] = {{"forward",
                        {{"inputs", {image}},
                         {"outputs", {result}},
                         {"tolerances", {{"float32", {{"atol", 0}, {"rtol", 0}}}}},
                         {"artifacts", {artifact}}}}};
    root["golden"] = file("golden.safetensors", golden);
    root["golden"]["cases"] = {{{"prefix", "case"}, {"method", "forward"}, {"dtype", nullptr}}};
    write_text(path + "/forward.toy", program);
    write_text(path + "/golden.safetensors", golden);
    write_text(path + "/manifest.json", root.dump());
    return path;
  }

  static std::vector<float> run(const Method& method) {
    const std::vector<float> values{0, 0.25f, 4};
    const Outputs outputs = method.run({Tensor(values.data(), {3})});
    const float* const result = outputs[0].data<const float>();
    return {result, result + 3};
  }

  TemporaryFolder folder_;
};

TEST_F(ExampleBackend, IsFoundBesideTheOthersByItsFileName) {
  const std::vector<BackendInfo> all = backends();
  const auto found =
      std::find_if(all.begin(), all.end(), [](const BackendInfo& info) { return info.name == "example"; });
  ASSERT_NE(found, all.end());
  EXPECT_TRUE(found->available);
  EXPECT_EQ(found->engine_version, "toy engine 1.0");
  EXPECT_EQ(&*found, &all.back()) << "its priority is the lowest";
}

TEST_F(ExampleBackend, RunsItsArtifactAndProvesItself) {
  const Bundle bundle = Bundle::open(write("scale 2\noffset 1"));
  const Method method = bundle.method("forward");
  EXPECT_EQ(method.backend(), "example");
  EXPECT_THAT(run(method), ElementsAre(1, 1.5f, 9));
  const std::vector<SelfTestRow> rows = bundle.self_test();
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].result, SelfTestRow::Result::Passed) << rows[0].message;
}

TEST_F(ExampleBackend, ItsArtifactsAreDataAndItsOptionsItsOwn) {
  const Bundle bundle = Bundle::open(write("scale 2\noffset 1"));
  EXPECT_THAT(run(bundle.method("forward", LoadOptions().with_allow_native_code(false))),
              ElementsAre(1, 1.5f, 9));
  EXPECT_THAT(run(bundle.method("forward", LoadOptions().with_backend("example").with_option("clamp", "1"))),
              ElementsAre(1, 1, 1));
  EXPECT_THAT(refusal(CHIASM_INVALID_ARGUMENT,
                      [&] {
                        bundle.method("forward",
                                      LoadOptions().with_backend("example").with_option("clamp", "yes"));
                      }),
              HasSubstr("the option clamp is 'yes', expected 0 or 1"));
  EXPECT_THAT(
      refusal(CHIASM_INVALID_ARGUMENT,
              [&] { bundle.method("forward", LoadOptions().with_backend("example").with_option("x", "1")); }),
      HasSubstr("the example backend has no option 'x'; it has clamp (0 or 1)"));
}

TEST_F(ExampleBackend, SaysWhatItCannotRun) {
  EXPECT_THAT(refusal(CHIASM_CORRUPT, [&] { Bundle::open(write("rotate 2")).method("forward"); }),
              HasSubstr("got 'rotate'"));
  EXPECT_THAT(refusal(CHIASM_NOT_FOUND, [&] { Bundle::open(write("scale 2", "plan")).method("forward"); }),
              HasSubstr("example: forward.toy is in a format that it does not load"));
  EXPECT_THAT(
      refusal(CHIASM_UNAVAILABLE,
              [&] {
                Bundle::open(write("scale 2")).method("forward", LoadOptions().with_device(Device::cuda()));
              }),
      HasSubstr("CUDA"));
}

}  // namespace
}  // namespace chiasm::testing
