/** Loading and closing leaves no mapping, file, thread or memory behind. $CHIASM_RELOADS is the number of
 *  repeats (`make soak`: 20,000). */
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <ctime>

#include "calls.h"

namespace chiasm::testing {
namespace {

/** By default, as many as take some seconds: 2,000 for native code. */
int reloads(const std::string& way) {
  const char* const text = std::getenv("CHIASM_RELOADS");
  return text != nullptr ? std::atoi(text) : way == "torch" ? 150 : way == "native" ? 2000 : 600;
}

class Reload : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Built, Reload, ::testing::ValuesIn(ways_to_call()),
                         [](const auto& info) { return info.param; });

TEST_P(Reload, LeavesNothingInTheProcess) {
  const std::string bundle = bundle_path("filters.sobel");
  const Inputs image = make_inputs(Bundle::open(bundle).methods().at(0), 1, 16);
  const auto once = [&] { return load(GetParam(), bundle)(image); };
  const std::string expected = once();
  const int count = reloads(GetParam());
  for (int i = 0; i < 100; ++i) once();  // allocates what engines and allocators keep for good
  const Holdings before = Holdings::now();
  const auto begun = std::chrono::steady_clock::now();
  const std::clock_t processor = std::clock();
  for (int i = 0; i < count; ++i) {
    if (once() != expected) FAIL() << "load " << i << " gives another answer than the first";
  }
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begun;
  const Holdings after = Holdings::now();
  std::printf("%s: %d loads in %.1f s, %.2f ms of processor time each; before: %s; after: %s\n",
              GetParam().c_str(), count, taken.count(),
              1e3 * static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC / count,
              before.text().c_str(), after.text().c_str());
  EXPECT_LE(after.maps, before.maps + 16) << before.text();  // an allocator may have more mappings
  EXPECT_EQ(after.files, before.files);
  EXPECT_EQ(after.threads, before.threads);
  EXPECT_LE(after.resident_kb, before.resident_kb + (16 << 10) + count / 2);
}

}  // namespace
}  // namespace chiasm::testing
