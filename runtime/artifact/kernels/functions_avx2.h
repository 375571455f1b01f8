// The functions of functions.h for AVX2: glibc's vector functions (libmvec), at most 4 units in the last
// place.
#pragma once

#include "lanes.h"

// NOLINTBEGIN(bugprone-reserved-identifier): the names are glibc's
extern "C" __m256d _ZGVdN4v_exp(__m256d);
extern "C" __m256d _ZGVdN4vv_atan2(__m256d, __m256d);
extern "C" __m256 _ZGVdN8vv_atan2f(__m256, __m256);
// NOLINTEND(bugprone-reserved-identifier)

namespace chiasm::kernels {

inline hn::Vec256<double> vector_exp(hn::Vec256<double> v) { return hn::Vec256<double>{_ZGVdN4v_exp(v.raw)}; }

inline hn::Vec256<double> vector_atan2(hn::Vec256<double> y, hn::Vec256<double> x) {
  return hn::Vec256<double>{_ZGVdN4vv_atan2(y.raw, x.raw)};
}

inline hn::Vec256<float> vector_atan2(hn::Vec256<float> y, hn::Vec256<float> x) {
  return hn::Vec256<float>{_ZGVdN8vv_atan2f(y.raw, x.raw)};
}

#if HWY_MAX_BYTES == 64
// By halves, so that results are the same as with AVX2.
inline hn::Vec512<double> vector_exp(hn::Vec512<double> v) {
  const hn::Half<Lanes<double>> half;
  return hn::Combine(Lanes<double>(), vector_exp(hn::UpperHalf(half, v)), vector_exp(hn::LowerHalf(half, v)));
}

template <class T>
inline hn::Vec512<T> vector_atan2(hn::Vec512<T> y, hn::Vec512<T> x) {
  const hn::Half<Lanes<T>> half;
  const auto high = vector_atan2(hn::UpperHalf(half, y), hn::UpperHalf(half, x));
  return hn::Combine(Lanes<T>(), high, vector_atan2(hn::LowerHalf(half, y), hn::LowerHalf(half, x)));
}
#endif

}  // namespace chiasm::kernels
