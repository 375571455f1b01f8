// Shared code for reading images at runs of positions: padding, and pixels that can be loaded together.
#pragma once

#include <cmath>

#include "rows.h"

namespace chiasm::kernels {

constexpr int64_t kRun = 256;

// Rounds half to even, by adding a number so large that no fraction is left. Unlike nearbyint it is
// vectorised.
inline float rounded(float x) { return (x + 12582912.0f) - 12582912.0f; }
inline double rounded(double x) { return (x + 6755399441055744.0) - 6755399441055744.0; }

// Folds positions into the image, by mirroring at the corner pixels' centres or at the outer edges.
template <class T>
inline void reflect(T* x, int64_t n, int64_t size, bool align_corners) {
  const T low = align_corners ? T(0) : T(-0.5),
          span = static_cast<T>(align_corners ? std::max<int64_t>(size - 1, 1) : size),
          last = static_cast<T>(size - 1);
  for (int64_t i = 0; i < n; ++i) {
    const T t = std::abs(x[i] - low), turns = std::floor(t / span), rest = t - turns * span;
    const T folded = (turns - 2 * std::floor(turns * T(0.5)) > T(0.5) ? span - rest : rest) + low;
    x[i] = std::min(std::max(folded, T(0)), last);
  }
}

// Runs of positions have room for whole vectors: values after their end are computed, too, and not used.

// Limits positions; NaN stays.
template <class T>
inline void limit(T* x, int64_t n, T low, T high) {
  const Lanes<T> d;
  for (int64_t i = 0; i < n; i += kLanes<T>)
    hn::StoreU(smaller(hn::Set(d, high), larger(hn::Set(d, low), hn::LoadU(d, x + i))), d, x + i);
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
