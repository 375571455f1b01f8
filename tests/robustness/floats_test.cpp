/** Callers with another floating-point environment: results are the same, there is no signal, and the
 *  caller's environment is kept. */
#include <fenv.h>
#include <gtest/gtest.h>

#include <string>

#include "base/floats.h"
#include "calls.h"
#include "child.h"

namespace chiasm::testing {
namespace {

using std::chrono::seconds;

class Floats : public ::testing::TestWithParam<std::string> {
 protected:
  const std::string bundle_ = bundle_path("filters.sobel");

  /** Every other value is subnormal, so an environment without subnormal numbers gives another result. */
  Inputs image() const {
    Inputs inputs = make_inputs(Bundle::open(bundle_).methods().at(0), 1, 700);
    auto* const values = reinterpret_cast<float*>(inputs.bytes[0].data());
    for (size_t i = 0; i < inputs.bytes[0].size() / sizeof(float); i += 2) values[i] = 1e-39f;
    return inputs;
  }

  /** Rounds up and has no subnormal numbers; with `traps`, every exception is a signal. */
  static void set_odd_environment(bool traps) {
    ::fesetround(FE_UPWARD);
#if defined(__x86_64__)
    constexpr unsigned kFlushToZero = 0x8000, kSubnormalsAreZeros = 0x0040;
    base::FloatControl::set(base::FloatControl::get() | kFlushToZero | kSubnormalsAreZeros);
#endif
    if (traps) ::feenableexcept(FE_ALL_EXCEPT);
  }
};

TEST_P(Floats, TheCallersEnvironmentDoesNotCount) {
  const Inputs inputs = image();
  const Ending plain = in_child(seconds(60), [&] { return load(GetParam(), bundle_)(inputs); });
  ASSERT_TRUE(plain.well()) << plain.text();
  // In the program's own session, ONNX Runtime's code runs in the caller's environment.
  const bool traps = GetParam() != "plugin";
  for (const bool odd_first : {true, false}) {
    const Ending child = in_child(seconds(60), [&]() -> std::string {
      set_num_threads(2);
      fenv_t before;
      ::fegetenv(&before);
      if (odd_first) set_odd_environment(traps);
      const Callable sobel = load(GetParam(), bundle_);
      const std::string first = sobel(inputs);
      ::fesetenv(&before);
      if (!odd_first) set_odd_environment(traps);
      const std::string second = sobel(inputs);
      const bool kept =
          odd_first || (::fegetround() == FE_UPWARD && ::fegetexcept() == (traps ? FE_ALL_EXCEPT : 0));
      ::fesetenv(&before);
      if (!kept) return "the environment is not the caller's any more";
      return first != plain.words ? "another answer" : second != plain.words ? "later another answer" : "";
    });
    EXPECT_TRUE(child.well()) << child.text();
    EXPECT_EQ(child.words, "") << (odd_first ? "the first call" : "a later call");
  }
}

INSTANTIATE_TEST_SUITE_P(Built, Floats, ::testing::ValuesIn(ways_to_call()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace chiasm::testing
