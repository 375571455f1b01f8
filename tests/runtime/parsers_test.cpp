/** The core's readers: expressions, manifests, safetensors, hashes. */
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "backends/native/archive.h"
#include "core/expression.h"
#include "core/file.h"
#include "core/golden.h"
#include "core/json.h"
#include "core/manifest.h"
#include "core/safetensors.h"
#include "core/status.h"
#include "support.h"

namespace chiasm::testing {
namespace {

using core::Error;
using core::Expression;
using Json = nlohmann::json;
using ::testing::HasSubstr;

const std::vector<std::string> kSymbols = {"H", "W"};

int64_t evaluate(const std::string& text, int64_t h = 7, int64_t w = 5) {
  const int64_t symbols[] = {h, w};
  int64_t value = 0;
  EXPECT_EQ(Expression::parse(text, kSymbols).evaluate(symbols, &value), Expression::Fault::none) << text;
  return value;
}

TEST(Expression, Evaluates) {
  EXPECT_EQ(evaluate("3"), 3);
  EXPECT_EQ(evaluate("H"), 7);
  EXPECT_EQ(evaluate("H+1"), 8);
  EXPECT_EQ(evaluate("2*H - W"), 9);
  EXPECT_EQ(evaluate("H - W - 1"), 1);
  EXPECT_EQ(evaluate("H//2 + 1"), 4);
  EXPECT_EQ(evaluate("(H+1)//2"), 4);
  EXPECT_EQ(evaluate("H*W//4*2"), 16);
  EXPECT_EQ(evaluate("-(H - W)*-3"), 6);
  EXPECT_EQ(evaluate(" ( ( H ) ) "), 7);
}

TEST(Expression, DividesTowardsMinusInfinity) {
  EXPECT_EQ(evaluate("-H//2"), -4);
  EXPECT_EQ(evaluate("H//-2"), -4);
  EXPECT_EQ(evaluate("-H//-2"), 3);
  EXPECT_EQ(evaluate("-8//2"), -4);
}

TEST(Expression, KnowsConstantsAndSymbols) {
  EXPECT_TRUE(Expression(4).is_constant());
  EXPECT_TRUE(Expression::parse("W", kSymbols).is_symbol());
  EXPECT_EQ(Expression::parse("W", kSymbols).operand(), 1);
  EXPECT_FALSE(Expression::parse("W+0", kSymbols).is_symbol());
}

TEST(Expression, ReportsOverflowAndDivisionByZero) {
  const int64_t big[] = {INT64_MAX, 0}, least[] = {INT64_MIN, -1};
  int64_t value = 0;
  for (const char* text : {"H+1", "2*H", "-H-2-H"}) {
    EXPECT_EQ(Expression::parse(text, kSymbols).evaluate(big, &value), Expression::Fault::overflow) << text;
  }
  EXPECT_EQ(Expression::parse("H//W", kSymbols).evaluate(big, &value), Expression::Fault::division_by_zero);
  EXPECT_EQ(Expression::parse("H//W", kSymbols).evaluate(least, &value), Expression::Fault::overflow);
  EXPECT_EQ(Expression::parse("-H", kSymbols).evaluate(least, &value), Expression::Fault::overflow);
}

TEST(Expression, TheDeepestFitsTheStack) {
  std::string text = "H";
  for (int i = 0; i < 16; ++i) text = "1+2*(" + text + ")";
  EXPECT_EQ(evaluate(text, 1), (int64_t{1} << 17) - 1);
}

TEST(Expression, RefusesWhatIsNone) {
  const std::string deep = std::string(40, '(') + "H" + std::string(40, ')');
  for (const std::string& text :
       {std::string(), std::string(" "), std::string("H+"), std::string("*H"), std::string("H H"),
        std::string("(H"), std::string("H)"), std::string("H/2"), std::string("H%2"), std::string("2H"),
        std::string("D"), std::string("99999999999999999999"), deep, std::string(40, '-') + "H",
        std::string(300, ' '), std::string("H\0+1", 4), std::string("\xff")}) {
    EXPECT_THROW(Expression::parse(text, kSymbols), Error) << text;
  }
}

/** The message of the error that `body` throws; fails if there is none, or one with another code. */
template <class Body>
std::string refusal(const Body& body, chiasm_code code = CHIASM_CORRUPT) {
  try {
    body();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "was accepted";
  return "";
}

std::string manifest_refusal(const std::function<void(Json&)>& change, chiasm_code code = CHIASM_CORRUPT) {
  Json root = manifest();
  change(root);
  return refusal([&] { core::parse_manifest(root.dump(), "x/manifest.json"); }, code);
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
        std::string(100000, '['), std::string("{\"name\":1,\"name\":2}"), std::string(1000, '\0')}) {
    EXPECT_THAT(refusal([&] { core::parse_manifest(text, "the-file"); }), HasSubstr("the-file"));
  }
  std::string nested;
  for (int i = 0; i < 50000; ++i) nested += "{\"a\":";
  EXPECT_THAT(refusal([&] { core::parse_manifest(nested, "f"); }), HasSubstr("nested deeper"));
  EXPECT_THAT(refusal([&] { core::parse_manifest(std::string((16u << 20) + 1, ' '), "f"); }),
              HasSubstr("longer than"));
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

TEST(File, Sha256IsThatOfTheStandard) {
  EXPECT_EQ(sha256_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(File, ChecksSizeAndHash) {
  const TemporaryFolder folder;
  const std::string path = folder.write("f", "abc");
  const core::Folder in(folder.path());
  EXPECT_EQ(in.read_checked("f", 3, sha256_of("abc")).size(), 3u);
  EXPECT_THAT(refusal([&] { in.read_checked("f", 4, sha256_of("abc")); }), HasSubstr(path + ": truncated"));
  EXPECT_THAT(refusal([&] { in.read_checked("f", 2, sha256_of("abc")); }), HasSubstr(path));
  EXPECT_THAT(refusal([&] { in.read_checked("f", 3, sha256_of("abd")); }), HasSubstr(path + ": changed"));
  EXPECT_THAT(refusal([&] { in.read_checked("fx", 3, ""); }, CHIASM_NOT_FOUND), HasSubstr(path + "x"));
  EXPECT_THAT(refusal([&] { in.read_checked(".", 3, ""); }), HasSubstr("not a regular file"));
}

std::map<std::string, core::StoredTensor> read(const std::string& file) {
  return core::read_safetensors(reinterpret_cast<const unsigned char*>(file.data()), file.size(), "g");
}

std::string with_header(const std::string& header, size_t data) {
  std::string file;
  for (int i = 0; i < 8; ++i) file += static_cast<char>((header.size() >> (8 * i)) & 255);
  return file + header + std::string(data, 'x');
}

TEST(Safetensors, Reads) {
  const std::string file = safetensors({{"a", {2, 2}, {1, 2, 3, 4}}, {"b", {}, {5}}});
  const auto tensors = read(file);
  ASSERT_EQ(tensors.size(), 2u);
  EXPECT_EQ(tensors.at("a").shape, (std::vector<int64_t>{2, 2}));
  float value = 0;
  std::memcpy(&value, tensors.at("b").data, sizeof value);
  EXPECT_EQ(value, 5);
  EXPECT_TRUE(read(with_header(R"({"__metadata__": {"format": "pt"}})", 0)).empty());
}

TEST(Safetensors, RefusesWhatDoesNotFit) {
  EXPECT_THROW(read(""), Error);
  EXPECT_THROW(read("1234567"), Error);
  EXPECT_THROW(read(std::string(8, '\xff')), Error);
  for (const char* header :
       {"[]", "{", R"({"a": 1})", R"({"a": {"dtype": "F32", "shape": [2], "data_offsets": [0, 4]}})",
        R"({"a": {"dtype": "F32", "shape": [2], "data_offsets": [4, 12]}})",
        R"({"a": {"dtype": "F32", "shape": [2], "data_offsets": [8, 0]}})",
        R"({"a": {"dtype": "F33", "shape": [2], "data_offsets": [0, 8]}})",
        R"({"a": {"dtype": "F32", "shape": [-2], "data_offsets": [0, 8]}})",
        R"({"a": {"dtype": "F32", "shape": [4611686018427387904, 4], "data_offsets": [0, 0]}})",
        R"({"a": {"dtype": "F32", "shape": [2], "data_offsets": [0]}})",
        R"({"a": {"dtype": "F32", "shape": [2]}})"}) {
    EXPECT_THROW(read(with_header(header, 8)), Error) << header;
  }
}

TEST(Compare, AppliesTheTolerance) {
  const float expected[] = {1, 100, -100}, actual[] = {1.05f, 101, -100};
  EXPECT_TRUE(core::compare(actual, expected, 3, CHIASM_FLOAT32, {0.05, 0.01}).passed);
  const core::Comparison strict = core::compare(actual, expected, 3, CHIASM_FLOAT32, {0.1, 0});
  EXPECT_FALSE(strict.passed);
  EXPECT_EQ(strict.mismatches, 1u);
  EXPECT_EQ(strict.worst, 1u);
  EXPECT_DOUBLE_EQ(strict.max_error, 1);
}

TEST(Compare, NanAndInfinity) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const double golden[] = {nan, inf, -inf, 1, 1, inf};
  EXPECT_TRUE(core::compare(golden, golden, 6, CHIASM_FLOAT64, {}).passed);
  const double actual[] = {1, -inf, 1, nan, inf, nan};
  EXPECT_EQ(core::compare(actual, golden, 6, CHIASM_FLOAT64, {1, 1}).mismatches, 6u);
}

TEST(Compare, DecodesHalfPrecision) {
  const uint16_t half[] = {0x3c00, 0x0001, 0x7c00, 0xc000}, other[] = {0x3c00, 0x0000, 0x7c00, 0xc001};
  const core::Comparison result = core::compare(half, other, 4, CHIASM_FLOAT16, {});
  EXPECT_EQ(result.mismatches, 2u);
  EXPECT_DOUBLE_EQ(result.max_error, std::ldexp(1, -9));
  const uint16_t brain[] = {0x3f80}, brain_other[] = {0x4000};
  EXPECT_DOUBLE_EQ(core::compare(brain, brain_other, 1, CHIASM_BFLOAT16, {}).max_error, 1);
}

TEST(Compare, LargeIntegersAreExact) {
  const int64_t a[] = {(int64_t{1} << 53) + 1}, b[] = {int64_t{1} << 53};
  EXPECT_FALSE(core::compare(a, b, 1, CHIASM_INT64, {}).passed);
}

/** A stored zip archive, by APPNOTE.TXT. */
class Zip {
 public:
  void add(const std::string& name, const std::string& content, unsigned method = 0, unsigned flags = 0) {
    const size_t offset = data_.size();
    const std::string common = u16(20) + u16(flags) + u16(method) + u16(0) + u16(0x21) + u32(0) +
                               u32(content.size()) + u32(content.size()) + u16(name.size()) + u16(2);
    data_ += u32(0x04034b50) + common + name + "xx" + content;
    directory_ += u32(0x02014b50) + u16(20) + common + u16(1) + u16(0) + u16(0) + u32(0) + u32(offset) +
                  name + "xx" + "c";
    ++count_;
  }
  std::string bytes(const std::string& comment = "") const {
    return data_ + directory_ + u32(0x06054b50) + u16(0) + u16(0) + u16(count_) + u16(count_) +
           u32(directory_.size()) + u32(data_.size()) + u16(comment.size()) + comment;
  }

 private:
  static std::string u16(size_t value) {
    return {static_cast<char>(value & 255), static_cast<char>(value >> 8 & 255)};
  }
  static std::string u32(size_t value) { return u16(value & 65535) + u16(value >> 16); }
  std::string data_, directory_;
  size_t count_ = 0;
};

std::string library_in(const std::string& archive) {
  const native::Bytes found = native::find_library(archive.data(), archive.size());
  return std::string(reinterpret_cast<const char*>(found.data), found.size);
}

TEST(Archive, FindsTheOneLibrary) {
  Zip zip;
  zip.add("op/readme.txt", "nothing");
  zip.add("op/code.so", "the code");
  zip.add("op/last", "");
  EXPECT_EQ(library_in(zip.bytes()), "the code");
  EXPECT_EQ(library_in(zip.bytes("a comment that says PK\5\6 itself")), "the code");
}

TEST(Archive, SaysWhatIsWrong) {
  const auto says = [](const std::string& archive) { return refusal([&] { library_in(archive); }); };
  Zip none, two, packed, secret;
  none.add("a.txt", "a");
  two.add("a.so", "a");
  two.add("b.so", "b");
  packed.add("a.so", "a", 8);
  secret.add("a.so", "a", 0, 1);
  EXPECT_EQ(says(""), "not a zip archive");
  EXPECT_EQ(says(std::string(100000, 'x')), "not a zip archive");
  EXPECT_THAT(says(none.bytes()), HasSubstr("no shared library"));
  EXPECT_THAT(says(two.bytes()), HasSubstr("a.so and b.so"));
  EXPECT_THAT(says(packed.bytes()), HasSubstr("'a.so' in the archive is compressed or encrypted"));
  EXPECT_THAT(says(secret.bytes()), HasSubstr("compressed or encrypted"));
}

TEST(Archive, AnyDamageIsAnErrorOrALibraryInside) {
  Zip zip;
  zip.add("a.txt", "text");
  zip.add("b.so", "library");
  const std::string whole = zip.bytes();
  for (size_t size = 0; size < whole.size(); ++size)
    EXPECT_THROW(library_in(whole.substr(0, size)), Error) << size;
  for (size_t at = 0; at < whole.size(); ++at) {
    for (const int value : {0, 1, 127, 255}) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(value);
      try {
        const native::Bytes found = native::find_library(damaged.data(), damaged.size());
        const auto* const begin = reinterpret_cast<const unsigned char*>(damaged.data());
        EXPECT_TRUE(found.data >= begin && found.data + found.size <= begin + damaged.size()) << at;
      } catch (const Error&) {}
    }
  }
}

}  // namespace
}  // namespace chiasm::testing
