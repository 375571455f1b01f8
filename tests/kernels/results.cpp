#include "results.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace kernel_calls {
namespace {

using chiasm::artifact::kDouble;
using chiasm::artifact::kFloat;

std::string file_of_this_test(const std::string& folder) {
  const ::testing::TestInfo* const test = ::testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(test->test_suite_name()) + "." + test->name() + ".bin";
  std::replace(name.begin(), name.end(), '/', '-');
  return folder + "/" + name;
}

template <class Stream>
void open(Stream& stream, const char* variable) {
  const char* const folder = std::getenv(variable);
  if (folder == nullptr) return;
  const std::string file = file_of_this_test(folder);
  stream.open(file, std::ios::binary);
  if (!stream) throw std::runtime_error(std::string(variable) + ": " + file + " cannot be opened");
}

template <class T>
std::string difference(const std::vector<char>& expected, const char* got, bool rounded) {
  const auto* const want = reinterpret_cast<const T*>(expected.data());
  const auto* const is = reinterpret_cast<const T*>(got);
  const size_t count = expected.size() / sizeof(T);
  double largest = 0;
  if constexpr (std::is_floating_point_v<T>)
    for (size_t i = 0; i < count; ++i)
      if (std::isfinite(want[i])) largest = std::max(largest, std::abs(static_cast<double>(want[i])));
  for (size_t i = 0; i < count; ++i) {
    if (std::memcmp(want + i, is + i, sizeof(T)) == 0) continue;
    if constexpr (std::is_floating_point_v<T>) {
      if (want[i] == is[i] || (std::isnan(want[i]) && std::isnan(is[i]))) continue;
      if (rounded && std::abs(static_cast<double>(want[i]) - static_cast<double>(is[i])) <=
                         64 * std::numeric_limits<T>::epsilon() * largest)
        continue;
    }
    return "value " + std::to_string(i) + " is " + std::to_string(is[i]) + ", was " + std::to_string(want[i]);
  }
  return "";
}

}  // namespace

Results::Results() {
  open(record_, "CHIASM_RECORD_RESULTS");
  open(expected_, "CHIASM_EXPECTED_RESULTS");
}

void Results::see(const AtenTensorOpaque& result, Comparison comparison) {
  const bool rounded = comparison == kRounded;
  const char* const data = const_cast<AtenTensorOpaque&>(result).data();
  const uint64_t bytes = result.storage->bytes;
  if (record_.is_open())
    record_.write(reinterpret_cast<const char*>(&bytes), sizeof bytes)
        .write(data, static_cast<std::streamsize>(bytes));
  if (!expected_.is_open()) return;
  uint64_t size = 0;
  ASSERT_TRUE(expected_.read(reinterpret_cast<char*>(&size), sizeof size))
      << "call " << seen_ << " was not made";
  ASSERT_EQ(size, bytes) << "call " << seen_;
  std::vector<char> expected(size);
  ASSERT_TRUE(expected_.read(expected.data(), static_cast<std::streamsize>(size))) << "call " << seen_;
  ++seen_;
  if (comparison == kAny) return;
  const std::string text = result.dtype == kFloat    ? difference<float>(expected, data, rounded)
                           : result.dtype == kDouble ? difference<double>(expected, data, rounded)
                                                     : difference<char>(expected, data, false);
  ASSERT_EQ(text, "") << "call " << seen_ - 1;
}

}  // namespace kernel_calls
