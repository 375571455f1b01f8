/** The core's reader of manifests. */
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/manifest.h"
#include "core/status.h"
#include "support.h"

namespace chiasm::testing {
namespace {

using core::Error;
using Json = nlohmann::json;
using ::testing::HasSubstr;

std::string manifest_refusal(const std::function<void(Json&)>& change, chiasm_code code = CHIASM_CORRUPT) {
  Json root = manifest();
  change(root);
  return refusal<Error>(code, [&] { core::parse_manifest(root.dump(), "x/manifest.json"); });
}

TEST(Manifest, ReadsAValidOne) {
  const core::Manifest read = core::parse_manifest(manifest().dump(), "m");
  EXPECT_EQ(read.name, "test.scale");
  ASSERT_EQ(read.methods.size(), 2u);
  const core::MethodSpec& forward = read.methods[0];
  EXPECT_EQ(forward.name, "forward");
  EXPECT_TRUE(forward.generic);
  EXPECT_EQ(forward.inputs[1].name, "sigma");
  EXPECT_EQ(forward.outputs[1].shape[1].text(), "(H+1)//2");
  EXPECT_EQ(forward.artifacts.size(), 5u);
  EXPECT_EQ(forward.artifacts[0].isa, core::Isa::x86_64_v3);
  EXPECT_EQ(forward.tolerances[CHIASM_FLOAT32]->atol, 1e-5);
  EXPECT_FALSE(forward.tolerances[CHIASM_UINT8].has_value());
}

TEST(Manifest, SaysWhichTensorsHaveSamples) {
  Json root = manifest();
  root["methods"]["forward"]["samples"] = "B";
  root["methods"]["forward"]["inputs"].push_back({{"name", "weights"},
                                                  {"dtype", "float32"},
                                                  {"shape", {3}},
                                                  {"description", ""},
                                                  {"layout", ""},
                                                  {"color", ""},
                                                  {"range", nullptr}});
  const core::Manifest read = core::parse_manifest(root.dump(), "m");
  EXPECT_EQ(read.methods[0].batched_inputs, 0b011u);
  EXPECT_EQ(read.methods[0].batched_outputs, 0b11u);
  EXPECT_EQ(read.methods[1].batched_outputs, 0u);
}

TEST(Manifest, SamplesMustBeCutAlongTheFirstDimension) {
  const auto refusal_of = [](const char* symbol, const std::function<void(Json&)>& change) {
    return manifest_refusal([&](Json& m) {
      m["methods"]["forward"]["samples"] = symbol;
      change(m);
    });
  };
  const auto outputs = [](Json& m) -> Json& { return m["methods"]["forward"]["outputs"]; };
  EXPECT_THAT(refusal_of("N", [](Json&) {}), HasSubstr("methods.forward.samples: there is no symbol 'N'"));
  EXPECT_THAT(refusal_of("H", [](Json&) {}), HasSubstr("'H' cannot be 1"));
  EXPECT_THAT(refusal_of("B", [&](Json& m) { outputs(m)[1]["shape"] = {"H"}; }),
              HasSubstr("an output has no first dimension 'B'"));
  EXPECT_THAT(refusal_of("B", [&](Json& m) { outputs(m)[1]["shape"] = {"2*B"}; }),
              HasSubstr("but 'half' has it elsewhere"));
  EXPECT_THAT(refusal_of("B",
                         [&](Json& m) {
                           outputs(m)[1]["shape"] = {"H", "B"};
                         }),
              HasSubstr("but 'half' has it elsewhere"));
}

TEST(Manifest, NewerSchemaIsAVersionMismatch) {
  const std::string message = manifest_refusal(
      [](Json& m) {
        m = {{"schema_version", 4}, {"whatever", true}};
      },
      CHIASM_VERSION_MISMATCH);
  EXPECT_THAT(message, HasSubstr("x/manifest.json: schema_version"));
  EXPECT_THAT(message, HasSubstr("newer chiasm (schema 4)"));
}

struct Damage {
  const char* pointer;  // the place
  Json value;           // the new value; discarded: the place is removed
  const char* message;  // a part of the expected error
};

class ManifestDamage : public ::testing::TestWithParam<Damage> {};

TEST_P(ManifestDamage, IsRefusedWithItsPlace) {
  const Damage& damage = GetParam();
  const std::string message = manifest_refusal([&damage](Json& m) {
    const Json::json_pointer pointer(damage.pointer);
    if (damage.value.is_discarded()) {
      m[pointer.parent_pointer()].erase(pointer.back());
    } else {
      m[pointer] = damage.value;
    }
  });
  EXPECT_THAT(message, HasSubstr("x/manifest.json: "));
  EXPECT_THAT(message, HasSubstr(damage.message));
}

const Json kRemoved(Json::value_t::discarded);

INSTANTIATE_TEST_SUITE_P(
    All, ManifestDamage,
    ::testing::Values(
        Damage{"/schema_version", "1", "schema_version: expected an integer, got string"},
        Damage{"/schema_version", 0, "schema_version"}, Damage{"/schema_version", 1.0, "expected an integer"},
        Damage{"/name", kRemoved, "the field 'name' is missing"},
        Damage{"/name", "../evil", "name: '../evil' is not a name"}, Damage{"/version", "1.0", "version"},
        Damage{"/version", "1..0", "version"}, Damage{"/version", "1.0.x", "version"},
        Damage{"/surprise", 1, "unknown field 'surprise'"}, Damage{"/producer/test", 3, "producer.test"},
        Damage{"/config", 3, "config: expected an object"}, Damage{"/created", kRemoved, "'created'"},
        Damage{"/created", "2026-01-01 00:00:00", "created: '2026-01-01 00:00:00' is not a time like"},
        Damage{"/symbols/H/min", 0, "symbols.H.min"},
        Damage{"/symbols/H/min", 9999, "min 9999 is greater than max 4096"},
        Damage{"/symbols/H/max", 1e300, "symbols.H.max"},
        Damage{"/symbols/H/max", UINT64_MAX, "symbols.H.max"},
        Damage{"/symbols/H-1", Json{{"min", 1}, {"max", 2}}, "is not a name"},
        Damage{"/symbols/H", kRemoved, "unknown symbol 'H'"},
        Damage{"/dtypes/0", "float31", "dtypes[0]: unknown dtype 'float31'"},
        Damage{"/dtypes/1", "float32", "dtypes[1]: occurs twice"},
        Damage{"/dtypes", Json::array(), "is T, but"},
        Damage{"/methods/forward", kRemoved, "methods: the field 'forward' is missing"},
        Damage{"/methods/forward/inputs", Json::array(), "methods.forward.inputs: has 0 elements"},
        Damage{"/methods/forward/inputs/0/dtype", "float",
               "methods.forward.inputs[0].dtype: unknown dtype 'float'"},
        Damage{"/methods/forward/inputs/1/name", "input",
               "inputs[1].name: a second tensor of the name 'input'"},
        Damage{"/methods/forward/outputs/0/name", "input", "outputs[0].name: a second tensor"},
        Damage{"/methods/forward/inputs/0/name", "a/b", "inputs[0].name"},
        Damage{"/methods/forward/inputs/0/shape/0", "D",
               "inputs[0].shape[0]: dimension 'D': unknown symbol 'D'"},
        Damage{"/methods/forward/inputs/0/shape/0", -1, "inputs[0].shape[0]"},
        Damage{"/methods/forward/inputs/0/shape/0", 2.5, "inputs[0].shape[0]"},
        Damage{"/methods/forward/inputs/0/shape",
               {1, 1, 1, 1, 1, 1, 1, 1, 1},
               "inputs[0].shape: has 9 elements"},
        Damage{"/methods/forward/inputs/0/shape/3", 8, "no input has the dimension 'W'"},
        Damage{"/methods/forward/inputs/0/range", {1, 0}, "inputs[0].range"},
        Damage{"/methods/forward/inputs/0/range", {0, 1, 2}, "inputs[0].range"},
        Damage{"/methods/forward/inputs/0/layout", 1, "inputs[0].layout"},
        Damage{"/methods/forward/artifacts/0/file", "../../etc/passwd", "artifacts[0].file"},
        Damage{"/methods/forward/artifacts/0/file", "a/b", "artifacts[0].file"},
        Damage{"/methods/forward/artifacts/0/file", "..", "artifacts[0].file"},
        Damage{"/methods/forward/artifacts/0/file", "a..b", "artifacts[0].file"},
        Damage{"/methods/forward/artifacts/0/file", ".hidden", "artifacts[0].file"},
        Damage{"/methods/forward/artifacts/0/file", "", "artifacts[0].file"},
        Damage{"/methods/forward/artifacts/0/file", std::string("a\0b", 3), "artifacts[0].file"},
        Damage{"/methods/forward/artifacts/0/size", 0, "artifacts[0].size"},
        Damage{"/methods/forward/artifacts/0/size", UINT64_MAX, "artifacts[0].size"},
        Damage{"/methods/forward/artifacts/0/sha256", std::string(64, 'A'), "artifacts[0].sha256"},
        Damage{"/methods/forward/artifacts/0/sha256", "00", "artifacts[0].sha256"},
        Damage{"/methods/forward/artifacts/0/backend", "Tensor RT",
               "'Tensor RT' is not a name of lower-case letters"},
        Damage{"/methods/forward/artifacts/0/format", "../onnx", "artifacts[0].format"},
        Damage{"/methods/forward/artifacts/0/needs", {"lib torch"}, "needs[0]: 'lib torch' is not a name"},
        Damage{"/methods/forward/artifacts/0/glibc", "2.36", "'glibc' is for schema version 3, this is 1"},
        Damage{"/methods/forward/artifacts/0/options",
               {{"a", "b"}},
               "'options' is for schema version 3, this is 1"},
        Damage{"/methods/forward/artifacts/0/isa", "sse2", "artifacts[0].isa"},
        Damage{"/methods/forward/artifacts/0/dtypes", {"int8"}, "int8 is not among"},
        Damage{"/methods/forward/artifacts/0/dtypes", Json::array(), "artifacts[0].dtypes: empty"},
        Damage{"/methods/forward/artifacts/0/device", "tpu", "artifacts[0].device"},
        Damage{"/methods/forward/artifacts/0/autograd", true, "'autograd' is for format torchscript only"},
        Damage{"/methods/forward/tolerances", kRemoved, "the field 'tolerances' is missing"},
        Damage{"/methods/forward/tolerances/float32/atol", -1, "must not be negative"},
        Damage{"/methods/vjp/tolerances/float32/rtol", "x", "tolerances.float32.rtol"},
        Damage{"/methods/forward/tolerances/float31", Json{{"atol", 0}, {"rtol", 0}},
               "unknown dtype 'float31'"},
        Damage{"/golden", kRemoved, "the field 'golden' is missing"},
        Damage{"/golden/file", "/golden", "golden.file"},
        Damage{"/golden/cases", Json::array(), "golden.cases: has 0 elements"},
        Damage{"/golden/cases/0/method", "backward", "there is no method 'backward'"},
        Damage{"/golden/cases/0/dtype", nullptr, "golden.cases[0].dtype: is null"}));

TEST(Manifest, ABackendOfAnyName) {
  const auto with = [](const Json& artifact) {
    Json m = manifest();
    m["schema_version"] = 3;
    m["methods"]["forward"]["artifacts"][0].update(artifact);
    return core::parse_manifest(m.dump(), "x/manifest.json");
  };
  const core::Manifest read = with({{"backend", "tensorrt"},
                                    {"format", "plan"},
                                    {"needs", {"cudnn"}},
                                    {"glibc", "2.36"},
                                    {"options", {{"workspace", "1 GiB"}}}});
  const core::Artifact& artifact = read.methods[0].artifacts[0];
  EXPECT_EQ(artifact.backend, "tensorrt");
  EXPECT_EQ(artifact.format, "plan");
  EXPECT_THAT(artifact.needs, ::testing::ElementsAre("cudnn"));
  EXPECT_EQ(artifact.glibc.major * 100 + artifact.glibc.minor, 236);
  EXPECT_EQ(artifact.option("workspace"), "1 GiB");
  EXPECT_EQ(artifact.option("other"), "");
  for (const char* version : {"2", "2.", ".3", "2.x", "2.3.4", "-2.3", "2.99999"})
    EXPECT_THROW(with({{"glibc", version}}), core::Error) << version;
  EXPECT_THROW(with({{"options", {{"Not a key", "x"}}}}), core::Error);
  EXPECT_THROW(with({{"options", {{"key", 1}}}}), core::Error);
}

TEST(Manifest, RefusesWhatIsNoJson) {
  for (const std::string& text :
       {std::string(), std::string("{"), std::string("[]"), std::string("null"), std::string("\"x\""),
        std::string("\xef\xbb\xbf"), std::string("{\"a\": \"\xff\"}"), std::string("{\"a\": 1e999}"),
        std::string(100000, '['), std::string("{\"name\":1,\"name\":2}"), std::string(1000, '\0'),
        manifest().dump() + '\0', manifest().dump() + std::string("\0{}", 3)}) {
    EXPECT_THAT(refusal<Error>(CHIASM_CORRUPT, [&] { core::parse_manifest(text, "the-file"); }),
                HasSubstr("the-file"));
  }
  std::string nested;
  for (int i = 0; i < 50000; ++i) nested += "{\"a\":";
  EXPECT_THAT(refusal<Error>(CHIASM_CORRUPT, [&] { core::parse_manifest(nested, "f"); }),
              HasSubstr("nested deeper"));
  EXPECT_THAT(
      refusal<Error>(CHIASM_CORRUPT, [&] { core::parse_manifest(std::string((16u << 20) + 1, ' '), "f"); }),
      HasSubstr("longer than"));
}

TEST(Manifest, ErrorsAreOneLineOfText) {
  const std::string odd = "a\n\x1b[31m" + std::string(100000, 'x');
  Json root = manifest();
  root[odd] = 1;
  const std::string twice =
      "{\"a\\u001b" + std::string(100000, 'x') + "\":1,\"a\\u001b" + std::string(100000, 'x') + "\":2}";
  for (const std::string& text : {root.dump(), twice, "{" + Json(odd).dump() + "}"}) {
    const std::string said = refusal<Error>(CHIASM_CORRUPT, [&] { core::parse_manifest(text, "the-file"); });
    EXPECT_LT(said.size(), 2000u);
    EXPECT_TRUE(std::all_of(said.begin(), said.end(), [](unsigned char c) { return c >= ' '; })) << said;
  }
}

TEST(Manifest, EveryPrefixIsRefusedAndNoneCrashes) {
  const std::string whole = manifest().dump();
  for (size_t size = 0; size < whole.size(); size += 7) {
    EXPECT_THROW(core::parse_manifest(std::string_view(whole).substr(0, size), "f"), Error);
  }
}

TEST(Manifest, Version2HasDocumentsAndReasons) {
  const Json sbom = {{"file", "sbom.cdx.json"}, {"size", 3}, {"sha256", sha256_of("abc")}};
  const auto version_2 = [&](const std::function<void(Json&)>& change) {
    return [&, change](Json& m) {
      m["schema_version"] = 2;
      m["documents"]["sbom"] = sbom;
      m["methods"]["forward"]["artifacts"][2]["why"] = "aten.foo";
      change(m);
    };
  };
  Json root = manifest();
  version_2([](Json&) {})(root);
  const core::Manifest read = core::parse_manifest(root.dump(), "m");
  ASSERT_EQ(read.documents.size(), 1u);
  EXPECT_EQ(read.documents[0].file, "sbom.cdx.json");
  EXPECT_EQ(read.methods[0].artifacts[2].why, "aten.foo");
  EXPECT_EQ(read.files.count("sbom.cdx.json"), 1u);
  EXPECT_EQ(read.files.count("golden.safetensors"), 1u);

  EXPECT_THAT(manifest_refusal(version_2([](Json& m) { m["schema_version"] = 1; })),
              HasSubstr("'documents' is for schema version 2"));
  EXPECT_THAT(manifest_refusal([](Json& m) { m["methods"]["forward"]["artifacts"][2]["why"] = "x"; }),
              HasSubstr("'why' is for schema version 2"));
  EXPECT_THAT(manifest_refusal(version_2([&](Json& m) { m["documents"]["again"] = sbom; })),
              HasSubstr("'sbom.cdx.json' is the name of another file"));
  for (const char* taken : {"golden.safetensors", "forward.pt"}) {
    EXPECT_THAT(manifest_refusal(version_2([&](Json& m) { m["documents"]["sbom"]["file"] = taken; })),
                HasSubstr("is the name of another file"));
  }
  for (const char* name : {"manifest.json", "manifest.json.minisig", "../x", "a/b", ".x", ""}) {
    EXPECT_THAT(manifest_refusal(version_2([&](Json& m) { m["documents"]["sbom"]["file"] = name; })),
                HasSubstr("is not the name of a file inside"));
  }
  EXPECT_THAT(manifest_refusal(version_2([](Json& m) { m["documents"]["sbom"].erase("sha256"); })),
              HasSubstr("documents.sbom: the field 'sha256' is missing"));
  EXPECT_THAT(manifest_refusal(version_2([](Json& m) { m["documents"]["sbom"]["more"] = 1; })),
              HasSubstr("unknown field 'more'"));
  EXPECT_THAT(manifest_refusal(version_2([](Json& m) { m["documents"] = Json::array(); })),
              HasSubstr("documents: expected an object"));
  std::string longest;
  for (int i = 0; i < 4096; ++i) longest += "\xc3\xa4";  // 4096 characters in 8192 bytes
  root["methods"]["forward"]["artifacts"][2]["why"] = longest;
  EXPECT_EQ(core::parse_manifest(root.dump(), "m").methods[0].artifacts[2].why, longest);
  EXPECT_THAT(manifest_refusal(version_2(
                  [&](Json& m) { m["methods"]["forward"]["artifacts"][2]["why"] = longest + "x"; })),
              HasSubstr("longer than 4096 characters"));
}

}  // namespace
}  // namespace chiasm::testing
