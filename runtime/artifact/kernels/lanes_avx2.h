// Conversions of lanes.h for AVX2: Highway's spend four more instructions on numbers outside an integer's
// range, which do not occur here.
#pragma once

namespace chiasm::kernels {

inline hn::Vec256<int32_t> truncated(Lanes<float>, hn::Vec256<float> v) {
  return hn::Vec256<int32_t>{_mm256_cvttps_epi32(v.raw)};
}

inline hn::Vec128<int32_t> truncated(Lanes<double>, hn::Vec256<double> v) {
  return hn::Vec128<int32_t>{_mm256_cvttpd_epi32(v.raw)};
}

}  // namespace chiasm::kernels
