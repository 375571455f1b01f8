// For NaN and for numbers that do not fit into an integer, kernels give the same results as the tensor forms
// in python/chiasm/primitives, in every part of a vector.
#include <cmath>
#include <limits>
#include <vector>

#include "fixture.h"
#include "kernels.h"

using namespace chiasm::kernels;

namespace {

template <class T>
class UndefinedKernels : public KernelsTest<T> {
 protected:
  static constexpr T kNan = std::numeric_limits<T>::quiet_NaN(),
                     kInfinity = std::numeric_limits<T>::infinity();
  UndefinedKernels() : KernelsTest<T>(31) {}
};

using Types = ::testing::Types<float, double>;
TYPED_TEST_SUITE(UndefinedKernels, Types);

TYPED_TEST(UndefinedKernels, APositionThatIsNotANumberIsOutsideTheImage) {
  using T = TypeParam;
  const std::vector<T> image(6 * 7, T(1));
  for (const Padding padding : {Padding::kZeros, Padding::kBorder, Padding::kReflection})
    for (const Interpolation mode :
         {Interpolation::kBilinear, Interpolation::kNearest, Interpolation::kBicubic})
      for (size_t broken = 0; broken < 19; ++broken) {
        std::vector<T> x(19, T(3)), y(19, T(2)), out(19);
        (broken % 2 ? x : y)[broken] = this->kNan;
        const T none = 0;
        remap(image.data(), {1, 1, 6, 7}, x.data(), 1, 19, y.data(), mode, padding, true, &none, 1,
              out.data());
        for (size_t i = 0; i < 19; ++i)
          ASSERT_EQ(out[i], i == broken ? T(0) : T(1)) << i << " with padding " << int(padding);
      }
}

TYPED_TEST(UndefinedKernels, AValueIsInTheNearestBinAndNanInTheFirst) {
  using T = TypeParam;
  const T most = std::numeric_limits<T>::max(), inf = this->kInfinity;
  const std::vector<T> x{this->kNan, -1, -inf, -most, T(0.1),  T(0.3), T(0.6),
                         T(0.9),     1,  2,    3e9,   T(1e20), most,   inf};
  const T low = 0, span = 1;
  int32_t counts[4];
  row_histograms(x.data(), 1, int64_t(x.size()), &low, &span, 4, counts);
  EXPECT_EQ(counts[0], 5);
  EXPECT_EQ(counts[1], 1);
  EXPECT_EQ(counts[2], 1);
  EXPECT_EQ(counts[3], 7);
  const T nothing = 0;  // all values are the same: 0 / 0 or infinite
  row_histograms(x.data() + 4, 1, 1, &low, &nothing, 4, counts);
  EXPECT_EQ(counts[3], 1);
}

TYPED_TEST(UndefinedKernels, WhatIsBesideNanIsNoExtremum) {
  using T = TypeParam;
  constexpr int64_t width = 23, plane = 3 * width;
  for (int64_t column = 1; column + 1 < width; ++column)
    for (const int64_t offset : {-plane - width - 1, -plane, -width - 1, -width, -width + 1, int64_t{-1},
                                 int64_t{1}, width - 1, width, width + 1, plane, plane + width + 1}) {
      const int64_t place = plane + width + column;
      std::vector<T> x(3 * plane, T(0));
      x[size_t(place)] = 1;
      const int64_t margins[3] = {1, 1, 1};
      int64_t found = 0;
      scale_space_nms(x.data(), {1, 3, 3, width}, margins, true, 1, &found);
      ASSERT_EQ(found, place);
      x[size_t(place + offset)] = this->kNan;
      scale_space_nms(x.data(), {1, 3, 3, width}, margins, true, 1, &found);
      ASSERT_EQ(found, -1) << "column " << column << ", NaN at " << offset;
    }
}

TYPED_TEST(UndefinedKernels, ABrokenPatchHasABrokenHistogram) {
  using T = TypeParam;
  for (const T broken : {this->kNan, this->kInfinity}) {
    auto patches = this->random(2 * 9 * 9);
    patches[40] = broken;
    const std::vector<T> window(81, T(1));
    std::vector<T> space_weights(2 * 9, T(0)), out(2 * 8 * 4);
    for (size_t i = 0; i < 9; ++i) space_weights[i / 5 * 9 + i] = 1;
    orientation_histograms(patches.data(), 2, 9, window.data(), space_weights.data(), 2, 8, out.data());
    for (size_t i = 0; i < 32; ++i) EXPECT_TRUE(std::isnan(out[i]));
    for (size_t i = 32; i < 64; ++i) EXPECT_TRUE(std::isfinite(out[i]));
  }
}

TYPED_TEST(UndefinedKernels, APatchIsReadWhereItsFrameIsANumber) {
  using T = TypeParam;
  const std::vector<T> pixels(9 * 9, T(1));
  const int64_t start[4] = {}, size[4] = {9, 9, 9, 9};
  const T most = std::numeric_limits<T>::max(), inf = this->kInfinity;
  // An ordinary frame; one with NaN; one that gives infinity except in its middle row and column, where
  // infinity is multiplied by 0; one whose sum is infinite.
  const std::vector<T> frames{2,   0, 4, 0, 2, 4, 2,    0,    this->kNan, 0, 2, 4,
                              inf, 0, 4, 0, 2, 4, most, most, most,       0, 2, 4};
  std::vector<T> out(4 * 25);
  extract_patches(pixels.data(), 1, 1, 81, start, 4, size, size, frames.data(), 5, out.data());
  for (size_t i = 0; i < 25; ++i) {
    EXPECT_EQ(out[i], T(1));
    EXPECT_TRUE(std::isnan(out[25 + i]));
    EXPECT_EQ(std::isnan(out[50 + i]), i % 5 == 2) << i;
    EXPECT_EQ(out[75 + i], T(1)) << i;  // at most infinite, which maps to the border
  }
}

TYPED_TEST(UndefinedKernels, AGuideThatIsNotANumberLeavesNoMean) {
  using T = TypeParam;
  const auto x = this->random(5 * 21);
  for (size_t broken = 0; broken < 21; ++broken) {
    auto guide = x;
    guide[2 * 21 + broken] = this->kNan;
    const std::vector<T> space_weights(9, T(0.5));
    const T range_coefficient = -1;
    std::vector<T> out(x.size());
    bilateral(x.data(), {1, 1, 5, 21}, guide.data(), 1, 1, space_weights.data(), 1, 3, 3, &range_coefficient,
              1, Border::kReplicate, false, out.data());
    for (int64_t r = 0; r < 5; ++r)
      for (int64_t c = 0; c < 21; ++c)
        ASSERT_EQ(std::isnan(out[size_t(r * 21 + c)]),
                  std::abs(r - 2) <= 1 && std::abs(c - int64_t(broken)) <= 1)
            << r << ", " << c << " of " << broken;
  }
}

}  // namespace
