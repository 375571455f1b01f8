/** The core's readers but that of manifests: expressions, files, safetensors, archives; and comparisons. */
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "backends/native/archive.h"
#include "core/expression.h"
#include "core/file.h"
#include "core/golden.h"
#include "core/json.h"
#include "core/safetensors.h"
#include "core/status.h"
#include "support.h"

namespace chiasm::testing {
namespace {

using core::Error;
using core::Expression;
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

TEST(File, Sha256IsThatOfTheStandard) {
  EXPECT_EQ(sha256_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(File, ChecksSizeAndHash) {
  const TemporaryFolder folder;
  const std::string path = folder.write("f", "abc");
  const core::Folder in(folder.path());
  EXPECT_EQ(in.read_checked("f", 3, sha256_of("abc")).size(), 3u);
  EXPECT_THAT(refusal<Error>(CHIASM_CORRUPT, [&] { in.read_checked("f", 4, sha256_of("abc")); }),
              HasSubstr(path + ": truncated"));
  EXPECT_THAT(refusal<Error>(CHIASM_CORRUPT, [&] { in.read_checked("f", 2, sha256_of("abc")); }),
              HasSubstr(path));
  EXPECT_THAT(refusal<Error>(CHIASM_CORRUPT, [&] { in.read_checked("f", 3, sha256_of("abd")); }),
              HasSubstr(path + ": changed"));
  EXPECT_THAT(refusal<Error>(CHIASM_NOT_FOUND, [&] { in.read_checked("fx", 3, ""); }), HasSubstr(path + "x"));
  EXPECT_THAT(refusal<Error>(CHIASM_CORRUPT, [&] { in.read_checked(".", 3, ""); }),
              HasSubstr("not a regular file"));
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
  const double finite[] = {1, 5}, infinite[] = {inf, 5.1};  // an infinity that came out finite is the worst
  EXPECT_EQ(core::compare(finite, infinite, 2, CHIASM_FLOAT64, {}).worst, 0u);
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
  const auto says = [](const std::string& archive) {
    return refusal<Error>(CHIASM_CORRUPT, [&] { library_in(archive); });
  };
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
