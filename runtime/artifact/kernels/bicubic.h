// Reads images at runs of positions by the cubic convolution kernel, on 4 x 4 pixels: R. Keys, Cubic
// Convolution Interpolation for Digital Image Processing, IEEE TASSP 29(6), 1981, with a = -0.75.
#pragma once

#include "positions.h"

namespace chiasm::kernels {

template <class D>
HWY_INLINE hn::Vec<D> keys(D d, hn::Vec<D> x) {
  const auto all = [=](double value) { return hn::Set(d, static_cast<hn::TFromD<D>>(value)); };
  const auto near = hn::Add(hn::Mul(hn::Mul(hn::Sub(hn::Mul(all(1.25), x), all(2.25)), x), x), all(1));
  const auto far =
      hn::Add(hn::Mul(hn::Sub(hn::Mul(hn::Add(hn::Mul(all(-0.75), x), all(3.75)), x), all(6)), x), all(3));
  return hn::IfThenElse(hn::Lt(x, all(1)), near, hn::IfThenElseZero(hn::Lt(x, all(2)), far));
}

// For each position, the four columns and the four rows that are read, and their weights.
template <class T>
struct CubicTaps {
  // How a vector of positions is read: pixel by pixel; each position as four rows of four neighbours; or each
  // row by loads of whole vectors, which contain the neighbours of all positions.
  enum class Way : uint8_t { kAnywhere, kInside, kTogether };

  alignas(64) int32_t column[4][kRun], row[4][kRun];
  alignas(64) int32_t index[kRun];  // the index of the last row and the first column
  alignas(64) T across[4][kRun], down[4][kRun];
  Way way[kRun / kLanes<T>];
};

template <class T>
inline void cubic_axis(T* x, int64_t n, int64_t size, Padding padding, bool align_corners,
                       int32_t (*pixel)[kRun], T (*weight)[kRun]) {
  const Lanes<T> d;
  const auto all = [=](auto value) { return hn::Set(d, static_cast<T>(value)); };
  // More than three pixels outside, results no longer change.
  if (padding != Padding::kReflection) limit(x, n, T(-4), static_cast<T>(size + 3));
  T first[kRun], at[kRun];
  for (int64_t i = 0; i < n; i += kLanes<T>) {
    const auto given = hn::LoadU(d, x + i), whole = hn::Floor(given), fraction = hn::Sub(given, whole);
    const auto known = hn::Eq(fraction, fraction);  // false for NaN and infinities
    const auto kept = hn::IfThenElse(known, whole, all(-4));
    // numbers beyond 2^52 have no fraction
    hn::StoreU(smaller(larger(kept, all(-4503599627370496.0)), all(4503599627370496.0)), d, first + i);
    const hn::Vec<Lanes<T>> distances[] = {hn::Add(fraction, all(1)), fraction, hn::Sub(all(1), fraction),
                                           hn::Sub(all(2), fraction)};
    for (int k = 0; k < 4; ++k)
      hn::StoreU(hn::IfThenElseZero(known, keys(d, distances[k])), d, weight[k] + i);
  }
  for (int k = 0; k < 4; ++k) {
    for (int64_t i = 0; i < n; i += kLanes<T>)
      hn::StoreU(hn::Add(hn::LoadU(d, first + i), all(k - 1)), d, at + i);
    if (padding == Padding::kReflection) reflect(at, n, size, align_corners);
    for (int64_t i = 0; i < n; i += kLanes<T>) {
      const auto place = hn::LoadU(d, at + i), nearest = smaller(larger(place, all(0)), all(size - 1));
      if (padding == Padding::kZeros)
        hn::StoreU(hn::IfThenElseZero(hn::Eq(place, nearest), hn::LoadU(d, weight[k] + i)), d, weight[k] + i);
      hn::StoreU(truncated(d, nearest), Integers<Lanes<T>>(), pixel[k] + i);
    }
  }
}

template <class T>
inline void cubic_taps(T* x, T* y, int64_t n, int64_t height, int64_t width, int64_t stride, Padding padding,
                       bool align_corners, CubicTaps<T>& taps) {
  cubic_axis(x, n, width, padding, align_corners, taps.column, taps.across);
  cubic_axis(y, n, height, padding, align_corners, taps.row, taps.down);
  for (int64_t i = 0; i < n; ++i)
    taps.index[i] = taps.row[3][i] * static_cast<int32_t>(stride) + taps.column[0][i];
  // the last index at which a vector can be loaded at the fourth pixel
  const int64_t last = height * stride - kLanes<T> - 3;
  for (int64_t i = 0; i + kLanes<T> <= n; i += kLanes<T>) {
    bool inside = true;
    for (int64_t j = i; j < i + kLanes<T>; ++j)
      for (int k = 0; k < 3; ++k)
        inside = inside & (taps.column[k + 1][j] - taps.column[k][j] == 1) &
                 (taps.row[k + 1][j] - taps.row[k][j] == 1);
    auto& way = taps.way[i / kLanes<T>];
    way = inside ? CubicTaps<T>::Way::kInside : CubicTaps<T>::Way::kAnywhere;
    if constexpr (sizeof(T) == sizeof(float))
      if (inside && taps.index[i] <= last && in_one_vector(from_first(taps.index + i)))
        way = CubicTaps<T>::Way::kTogether;
  }
}

// The four neighbours from p on at each index.
template <class T>
HWY_INLINE void load_fours(const T* p, const int32_t* index, hn::Vec<Lanes<T>>* four) {
  const Lanes<T> d;
  if constexpr (sizeof(T) == sizeof(float)) {
    const hn::FixedTag<T, 4> part;
    const auto every_fourth = [=](int64_t k) {
      return combined<decltype(part)>(d, [=](int64_t i) { return hn::LoadU(part, p + index[i + k]); });
    };
    const auto a = every_fourth(0), b = every_fourth(1), c = every_fourth(2), e = every_fourth(3);
    const auto low_even = hn::InterleaveLower(d, a, c), low_odd = hn::InterleaveLower(d, b, e),
               high_even = hn::InterleaveUpper(d, a, c), high_odd = hn::InterleaveUpper(d, b, e);
    four[0] = hn::InterleaveLower(d, low_even, low_odd);
    four[1] = hn::InterleaveUpper(d, low_even, low_odd);
    four[2] = hn::InterleaveLower(d, high_even, high_odd);
    four[3] = hn::InterleaveUpper(d, high_even, high_odd);
  } else {
    for (int k = 0; k < 4; ++k) four[k] = gathered(d, p + k, index);
  }
}

// The products are added up row by row, in the definition's order.
template <class T>
inline void bicubic(const T* plane, int64_t stride, const CubicTaps<T>& taps, int64_t n, T* out) {
  using Way = typename CubicTaps<T>::Way;
  const Lanes<T> d;
  int64_t i = 0;
  // load(k, four) gives the four pixels of row k
  const auto sum = [=, &taps](int64_t first, const auto& load) {
    auto total = hn::Zero(d);
    for (int k = 0; k < 4; ++k) {
      hn::Vec<Lanes<T>> four[4];
      load(k, four);
      const auto down = hn::Load(d, taps.down[k] + first);
      for (int j = 0; j < 4; ++j)
        total = hn::Add(total, hn::Mul(four[j], hn::Mul(down, hn::Load(d, taps.across[j] + first))));
    }
    hn::StoreU(total, d, out + first);
  };
  for (; i + kLanes<T> <= n; i += kLanes<T>) {
    const int32_t* const index = taps.index + i;
    const Way way = taps.way[i / kLanes<T>];
    if constexpr (sizeof(T) == sizeof(float)) {
      if (way == Way::kTogether) {
        const auto from = hn::IndicesFromVec(d, from_first(index));
        sum(i, [=](int k, hn::Vec<Lanes<T>>* four) {
          for (int j = 0; j < 4; ++j)
            four[j] = hn::TableLookupLanes(hn::LoadU(d, plane + *index + (k - 3) * stride + j), from);
        });
        continue;
      }
    }
    if (way == Way::kInside)
      sum(i, [=](int k, hn::Vec<Lanes<T>>* four) { load_fours(plane + (k - 3) * stride, index, four); });
    else
      sum(i, [=, &taps](int k, hn::Vec<Lanes<T>>* four) {
        for (int j = 0; j < 4; ++j) {
          T pixels[kLanes<T>];
          for (int64_t l = 0; l < kLanes<T>; ++l)
            pixels[l] = plane[taps.row[k][i + l] * stride + taps.column[j][i + l]];
          four[j] = hn::LoadU(d, pixels);
        }
      });
  }
  for (; i < n; ++i) {
    T total = 0;
    for (int k = 0; k < 4; ++k)
      for (int j = 0; j < 4; ++j)
        total += plane[taps.row[k][i] * stride + taps.column[j][i]] * (taps.down[k][i] * taps.across[j][i]);
    out[i] = total;
  }
}

}  // namespace chiasm::kernels
