// Conversions of lanes.h for AVX2: Highway's guards numbers that no integer holds, of which there are none,
// by four more instructions.
#pragma once

namespace chiasm::kernels {

inline hn::Vec256<int32_t> truncated(Lanes<float>, hn::Vec256<float> v) {
  return hn::Vec256<int32_t>{_mm256_cvttps_epi32(v.raw)};
}

inline hn::Vec128<int32_t> truncated(Lanes<double>, hn::Vec256<double> v) {
  return hn::Vec128<int32_t>{_mm256_cvttpd_epi32(v.raw)};
}

}  // namespace chiasm::kernels
