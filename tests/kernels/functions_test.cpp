// The functions of vectors that every CPU has, against the C library's.
#include "artifact/kernels/functions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace chiasm::kernels {
namespace {

template <class T>
std::vector<T> numbers() {
  constexpr T kInfinity = std::numeric_limits<T>::infinity(), kLargest = std::numeric_limits<T>::max();
  std::vector<T> made = {T(0),      T(1),
                         T(0.5),    T(2),
                         T(1e-30),  T(1e30),
                         kLargest,  std::numeric_limits<T>::denorm_min(),
                         kInfinity, std::numeric_limits<T>::quiet_NaN()};
  std::mt19937 generator(1);
  std::lognormal_distribution<T> drawn(0, 2);
  while (made.size() < 150) made.push_back(drawn(generator));
  for (size_t i = 0, size = made.size(); i < size; ++i) made.push_back(-made[i]);
  return made;
}

/** The distance in units in the last place of `expected`; 0 for two NaN, or the same with its sign. */
template <class T>
double distance(T value, T expected) {
  if (std::isnan(value) && std::isnan(expected)) return 0;
  if (value == expected && std::signbit(value) == std::signbit(expected)) return 0;
  const T size = std::abs(expected);
  return std::abs(value - expected) / (std::nextafter(size, std::numeric_limits<T>::infinity()) - size);
}

/** The last value of a vector, and a vector of one. */
template <class T, class Function>
void expect_near(T expected, const Function& function, double limit) {
  T one, all[kLanes<T>];
  hn::StoreU(function(Lane<T>()), Lane<T>(), &one);
  hn::StoreU(function(Lanes<T>()), Lanes<T>(), all);
  EXPECT_LE(distance(one, expected), limit) << one << " " << expected;
  EXPECT_LE(distance(all[kLanes<T> - 1], expected), limit) << all[kLanes<T> - 1] << " " << expected;
}

template <class T>
class Functions : public ::testing::Test {};
using Floats = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Functions, Floats);

TYPED_TEST(Functions, AtanOfTwoNumbers) {
  for (const TypeParam y : numbers<TypeParam>())
    for (const TypeParam x : numbers<TypeParam>())
      expect_near<TypeParam>(
          std::atan2(y, x), [=](auto d) { return vector_atan2(hn::Set(d, y), hn::Set(d, x)); }, 4);
}

TYPED_TEST(Functions, ExpOfWhatIsNotPositive) {
  for (const TypeParam v : numbers<TypeParam>()) {
    const TypeParam expected = std::exp(v);
    if (v > 0 || (expected > 0 && expected < std::numeric_limits<TypeParam>::min())) continue;
    expect_near<TypeParam>(
        expected, [=](auto d) { return vector_exp(hn::Set(d, v)); }, 4);
  }
}

}  // namespace
}  // namespace chiasm::kernels
