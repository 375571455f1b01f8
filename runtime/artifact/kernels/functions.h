// Functions of single values for Highway's vectors: value by value, except those in functions_avx2.h.
#pragma once

#include <cmath>

#include "lanes.h"

namespace chiasm::kernels {

/** function(a, b) for each pair of values. */
template <class V, class Function>
inline V of_each(V a, V b, const Function& function) {
  const hn::DFromV<V> d;
  hn::TFromV<V> left[hn::MaxLanes(d)], right[hn::MaxLanes(d)];
  hn::StoreU(a, d, left);
  hn::StoreU(b, d, right);
  for (size_t i = 0; i < hn::Lanes(d); ++i) left[i] = function(left[i], right[i]);
  return hn::LoadU(d, left);
}

template <class V>
inline V vector_exp(V v) {
  return of_each(v, v, [](auto x, auto) { return std::exp(x); });
}

template <class V>
inline V vector_atan2(V y, V x) {
  return of_each(y, x, [](auto a, auto b) { return std::atan2(a, b); });
}

}  // namespace chiasm::kernels

#if HWY_ARCH_X86 && HWY_MAX_BYTES >= 32
#include "functions_avx2.h"
#endif
