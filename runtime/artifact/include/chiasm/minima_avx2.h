// Minima and maxima by AVX2's own instruction, which returns the second value if one is NaN.
#pragma once

#include <immintrin.h>

namespace chiasm {

inline at::vec::Vectorized<float> smaller(const at::vec::Vectorized<float>& a,
                                          const at::vec::Vectorized<float>& b) {
  return _mm256_min_ps(a, b);
}
inline at::vec::Vectorized<float> larger(const at::vec::Vectorized<float>& a,
                                         const at::vec::Vectorized<float>& b) {
  return _mm256_max_ps(a, b);
}

}  // namespace chiasm
