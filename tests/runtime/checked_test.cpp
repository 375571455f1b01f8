// The checks that compiled loops call (artifact/include/chiasm/checked.h), on scalars: the vector forms are
// in every artifact's tests.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>

#define INDUCTOR_USE_VECTOR_TYPES() 0
#include "artifact/include/chiasm/checked.h"

namespace {

int64_t noted_index, noted_size, divisions;

}  // namespace

namespace chiasm {
void note_index(int64_t index, int64_t size, const char*) {
  noted_index = index;
  noted_size = size;
}
void note_division() { ++divisions; }
}  // namespace chiasm

namespace {

using chiasm::checked_index;

TEST(Checked, AnIndexInRangeIsItself) {
  noted_size = 0;
  for (int64_t i = 0; i < 16; ++i) EXPECT_EQ(checked_index<true>(i, 16, "test"), i);
  EXPECT_EQ(checked_index<false>(int32_t{15}, 16, "test"), 15);
  EXPECT_EQ(noted_size, 0);
}

TEST(Checked, AnotherIsNotedAsItCameAndBecomesZero) {
  EXPECT_EQ(checked_index<false>(int64_t{16}, 16, "test"), 0);
  EXPECT_EQ(noted_index, 16);
  EXPECT_EQ(noted_size, 16);
  EXPECT_EQ(checked_index<true>(int64_t{-17} + 16, 16, "test"), 0);  // the size was added before
  EXPECT_EQ(noted_index, -17);
  EXPECT_EQ(checked_index<false>(std::numeric_limits<int32_t>::min(), 16, "test"), 0);
  EXPECT_EQ(noted_index, std::numeric_limits<int32_t>::min());
}

TEST(Checked, WhatIsNotUsedIsNotNoted) {
  noted_size = 0;
  EXPECT_EQ(checked_index<false>(int64_t{99}, 16, "test", false), 0);
  EXPECT_EQ(noted_size, 0);
}

TEST(Checked, DivisionsAreThoseOfTheirDefinitions) {
  divisions = 0;
  for (int a = -20; a <= 20; ++a)
    for (int b = -7; b <= 7; ++b) {
      if (b == 0) continue;
      const int floor = static_cast<int>(std::floor(double(a) / b));
      EXPECT_EQ(chiasm::floor_divide_integral(a, b), floor) << a << " " << b;
      EXPECT_EQ(chiasm::remainder_integral(a, b), a - floor * b) << a << " " << b;
      EXPECT_EQ(chiasm::truncated_quotient(a, b), static_cast<int>(std::trunc(double(a) / b)))
          << a << " " << b;
      EXPECT_EQ(chiasm::mod(a, b), static_cast<int>(std::fmod(a, b))) << a << " " << b;
    }
  EXPECT_EQ(divisions, 0);
}

TEST(Checked, NoDivisionTraps) {
  const int64_t least = std::numeric_limits<int64_t>::min();
  EXPECT_EQ(chiasm::truncated_quotient(least, int64_t{-1}), least);  // it wraps
  EXPECT_EQ(chiasm::floor_divide_integral(least, int64_t{-1}), least);
  EXPECT_EQ(chiasm::mod(least, int64_t{-1}), 0);
  EXPECT_EQ(chiasm::remainder_integral(least, int64_t{-1}), 0);
  divisions = 0;
  EXPECT_EQ(chiasm::truncated_quotient(5, 0), 0);
  EXPECT_EQ(chiasm::floor_divide_integral(5u, 0u), 0u);
  EXPECT_EQ(chiasm::remainder_integral(int8_t{5}, int8_t{0}), 0);
  EXPECT_EQ(divisions, 3);
}

}  // namespace
