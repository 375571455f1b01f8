// Values at even and odd places for AVX2, whose shuffles stay within halves of a vector: what resample.cpp has for every CPU moves values between the halves
// for each two of them, this once for their sum.
#pragma once

#include "lanes.h"

namespace chiasm::kernels {

inline void deinterleave(Lanes<float>, const float* p, hn::Vec256<float>& even, hn::Vec256<float>& odd) {
  const __m256 low = _mm256_loadu_ps(p), high = _mm256_loadu_ps(p + 8);
  even = hn::Vec256<float>{_mm256_shuffle_ps(low, high, 0b10001000)};
  odd = hn::Vec256<float>{_mm256_shuffle_ps(low, high, 0b11011101)};
}

inline void deinterleave(Lanes<double>, const double* p, hn::Vec256<double>& even, hn::Vec256<double>& odd) {
  const __m256d low = _mm256_loadu_pd(p), high = _mm256_loadu_pd(p + 4);
  even = hn::Vec256<double>{_mm256_unpacklo_pd(low, high)};
  odd = hn::Vec256<double>{_mm256_unpackhi_pd(low, high)};
}

inline hn::Vec256<double> ordered(hn::Vec256<double> v) { return hn::Vec256<double>{_mm256_permute4x64_pd(v.raw, 0b11011000)}; }

inline hn::Vec256<float> ordered(hn::Vec256<float> v) {
  return hn::Vec256<float>{_mm256_castpd_ps(_mm256_permute4x64_pd(_mm256_castps_pd(v.raw), 0b11011000))};
}

}  // namespace chiasm::kernels
