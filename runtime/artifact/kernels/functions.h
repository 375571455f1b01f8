// Functions of vectors: Highway's own, except those in functions_avx2.h, which are 1.5 to 2 times as fast.
#pragma once

#include "lanes.h"

#include <hwy/contrib/math/math-inl.h>

namespace chiasm::kernels {

/** e^v for v of at most 0, or NaN, which Highway's exponential makes 0. */
template <class V>
inline V vector_exp(V v) {
  return hn::IfThenElse(hn::IsNaN(v), v, hn::CallExp(hn::DFromV<V>(), v));
}

/** The angle of the point (x, y), as std::atan2. */
template <class V>
inline V vector_atan2(V y, V x) {
  const hn::DFromV<V> d;
  using T = hn::TFromV<V>;
  const V zero = hn::Zero(d), one = hn::Set(d, T(1)), pi = hn::Set(d, static_cast<T>(3.14159265358979323846));
  const V wide = hn::Abs(x), high = hn::Abs(y);
  const auto is_steep = hn::Gt(high, wide);
  const V longer = hn::IfThenElse(is_steep, high, wide), shorter = hn::IfThenElse(is_steep, wide, high);
  // of two infinities 1, of two zeros 0
  const V diagonal = hn::IfThenElse(hn::Eq(longer, zero), zero, one);
  const V slope = hn::IfThenElse(hn::Eq(shorter, longer), diagonal, hn::Div(shorter, longer));
  V angle = hn::CallAtan(d, slope);
  angle = hn::IfThenElse(is_steep, hn::Sub(hn::Mul(pi, hn::Set(d, T(0.5))), angle), angle);
  const auto is_left = hn::Lt(hn::CopySign(one, x), zero);
  return hn::CopySign(hn::IfThenElse(is_left, hn::Sub(pi, angle), angle), y);
}

}  // namespace chiasm::kernels

#if HWY_ARCH_X86 && HWY_MAX_BYTES >= 32
#include "functions_avx2.h"
#endif
