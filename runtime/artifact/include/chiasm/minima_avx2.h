// Minima and maxima by AVX2's own instruction, which returns the second value if either is NaN. PyTorch's
// return NaN if either is, and take three instructions.
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

// Whether the compiler knows all lanes of a bound, as in a clamp, and that none is NaN. Then only the other
// value can be NaN, and the instruction returns it if it is the second one.
inline bool is_known_bound(const at::vec::Vectorized<float>& bound) {
  const auto v = static_cast<__m256>(bound);
  const auto same = v == v;
  const bool all = (same[0] & same[1] & same[2] & same[3] & same[4] & same[5] & same[6] & same[7]) != 0;
  return __builtin_constant_p(all) && all;
}
inline at::vec::Vectorized<float> minimum(const at::vec::Vectorized<float>& a,
                                          const at::vec::Vectorized<float>& b) {
  return is_known_bound(b) ? at::vec::Vectorized<float>(_mm256_min_ps(b, a)) : at::vec::minimum(a, b);
}
inline at::vec::Vectorized<float> maximum(const at::vec::Vectorized<float>& a,
                                          const at::vec::Vectorized<float>& b) {
  return is_known_bound(b) ? at::vec::Vectorized<float>(_mm256_max_ps(b, a)) : at::vec::maximum(a, b);
}

}  // namespace chiasm
