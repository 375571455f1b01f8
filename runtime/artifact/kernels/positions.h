// Shared code for reading images at runs of positions: padding, and pixels that can be loaded together.
#pragma once

#include <cmath>

#include "rows.h"

namespace chiasm::kernels {

constexpr int64_t kRun = 256;

// Runs of positions have room for whole vectors: values after their end are computed, too, and not used.

// Limits positions; NaN stays.
template <class T>
inline void limit(T* x, int64_t n, T low, T high) {
  const Lanes<T> d;
  for (int64_t i = 0; i < n; i += kLanes<T>)
    hn::StoreU(smaller(hn::Set(d, high), larger(hn::Set(d, low), hn::LoadU(d, x + i))), d, x + i);
}

// Folds positions into the image, by mirroring at the corner pixels' centres or at the outer edges. A vector
// whose positions are all inside of the image, as most are, needs no division.
template <class T>
inline void reflect(T* x, int64_t n, int64_t size, bool align_corners) {
  const Lanes<T> d;
  const auto all = [=](auto value) { return hn::Set(d, static_cast<T>(value)); };
  const auto low = all(align_corners ? 0 : -0.5), last = all(size - 1),
             span = all(align_corners ? std::max<int64_t>(size - 1, 1) : size);
  for (int64_t i = 0; i < n; i += kLanes<T>) {
    const auto given = hn::LoadU(d, x + i);
    auto rest = hn::Abs(hn::Sub(given, low));
    if (!hn::AllTrue(d, hn::And(hn::Ge(given, all(0)), hn::Le(given, last)))) {
      const auto turns = hn::Floor(hn::Div(rest, span));
      rest = hn::Sub(rest, hn::Mul(turns, span));
      const auto half_turns = hn::Floor(hn::Mul(turns, all(0.5)));
      const auto is_odd = hn::Gt(hn::Sub(turns, hn::Add(half_turns, half_turns)), all(0.5));
      rest = hn::IfThenElse(is_odd, hn::Sub(span, rest), rest);
    }
    hn::StoreU(smaller(last, larger(all(0), hn::Add(rest, low))), d, x + i);
  }
}

template <class T>
inline void place(T* x, int64_t n, int64_t size, Padding padding, bool align_corners) {
  if (padding == Padding::kBorder) limit(x, n, T(0), static_cast<T>(size - 1));
  if (padding == Padding::kReflection) reflect(x, n, size, align_corners);
}

// If a row is read forwards in steps of at most one, the pixels at a vector of indices lie in one vector.
// These are their offsets from the first one.
using Indices = Integers<Lanes<float>>;

HWY_INLINE hn::Vec<Indices> from_first(const int32_t* index) {
  const Indices integers;
  return hn::Sub(hn::LoadU(integers, index), hn::Set(integers, *index));
}

HWY_INLINE bool in_one_vector(hn::Vec<Indices> from_first) {
  const Indices integers;
  return hn::AllTrue(
      integers, hn::Eq(hn::And(from_first, hn::Set(integers, ~(static_cast<int32_t>(kLanes<float>) - 1))),
                       hn::Zero(integers)));
}

}  // namespace chiasm::kernels
