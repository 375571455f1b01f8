// Vectors of numbers by Google Highway, as long as the CPU's, so that a kernel is written once for every
// instruction set. The instruction set is chosen when a kernel is compiled; there is no dispatch at run time.
#pragma once

// Without this Highway takes x86-64-v3 for SSSE3, because that level lacks the AES instructions, which no
// kernel uses.
#define HWY_DISABLE_PCLMUL_AES
// Kernels keep vectors in arrays and structures. SVE's vectors cannot be members, because the compiler does
// not know their length. CPUs with SVE have NEON too.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
// No assertions, which would need Highway's library.
#define HWY_IS_DEBUG_BUILD 0
#include <hwy/highway.h>

#include <hwy/cache_control.h>

#include <cstdint>
#include <type_traits>

namespace chiasm::kernels {

namespace hn = hwy::HWY_NAMESPACE;

/** Highway's tags of a whole vector, and of a vector of one value. */
template <class T>
using Lanes = hn::ScalableTag<T>;
template <class T>
using Lane = hn::CappedTag<T, 1>;

template <class T>
constexpr int64_t kLanes = static_cast<int64_t>(hn::MaxLanes(Lanes<T>()));

/** The loop over n values of a row. It calls body(tag, vectors, first) for blocks of kVectors vectors, then
 *  for the remaining whole vectors (`vectors` is the constant 1), and then for the remaining values, as
 *  vectors of one. So a kernel has one body, and its result does not depend on where a row ends.
 *
 *  The body captures by value: variables behind a reference would be loaded again after every store of a
 *  vector, which may alias them.
 *
 *  With `again` the end is a whole vector that overlaps the last, for bodies that may compute values twice
 *  because they do not read what they write. */
template <class T, int kVectors = 1, bool again = false, class Body>
HWY_INLINE void for_lanes(int64_t n, const Body& body) {
  constexpr std::integral_constant<int, kVectors> several;
  constexpr std::integral_constant<int, 1> one;
  int64_t k = 0;
  for (; kVectors > 1 && k + kVectors * kLanes<T> <= n; k += kVectors * kLanes<T>)
    body(Lanes<T>(), several, k);
  for (; k + kLanes<T> <= n; k += kLanes<T>) body(Lanes<T>(), one, k);
  if (again && k < n && n >= kLanes<T>) return body(Lanes<T>(), one, n - kLanes<T>);
  for (; k < n; ++k) body(Lane<T>(), one, k);
}

/** a > b ? a : b and a < b ? a : b, so the second if either is NaN. This is x86's instruction; those of other
 *  CPUs return the number, or NaN. For integers all agree. */
constexpr bool kSelects = !HWY_ARCH_X86 || HWY_TARGET == HWY_EMU128;

template <class V>
HWY_INLINE V larger(V a, V b) {
  if constexpr (!kSelects || !hwy::IsFloat<hn::TFromV<V>>())
    return hn::Max(a, b);
  else
    return hn::IfThenElse(hn::Gt(a, b), a, b);
}

template <class V>
HWY_INLINE V smaller(V a, V b) {
  if constexpr (!kSelects || !hwy::IsFloat<hn::TFromV<V>>())
    return hn::Min(a, b);
  else
    return hn::IfThenElse(hn::Lt(a, b), a, b);
}

template <class D, class Mask>
HWY_INLINE bool any(D d, Mask mask) {
  return !hn::AllFalse(d, mask);
}

/** A tag's integers of 32 bits, for indices and whole numbers. */
template <class D>
using Integers = hn::Rebind<int32_t, D>;

/** The values without their fractions; they must be in an integer's range. */
template <class D>
HWY_INLINE hn::Vec<Integers<D>> truncated(D, hn::Vec<D> v) {
  const Integers<D> integers;
  if constexpr (sizeof(hn::TFromD<D>) == 8)
    return hn::DemoteTo(integers, v);
  else
    return hn::ConvertTo(integers, v);
}

/** p[index[i]] for each lane i. */
template <class D>
HWY_INLINE hn::Vec<D> gathered(D d, const hn::TFromD<D>* p, const int32_t* index) {
  const auto integers = hn::LoadU(Integers<D>(), index);
  if constexpr (sizeof(hn::TFromD<D>) == 8)
    return hn::GatherIndex(d, p, hn::PromoteTo(hn::RebindToSigned<D>(), integers));
  else
    return hn::GatherIndex(d, p, integers);
}

/** A vector composed of part(i) for each of its parts of type Part; i is the part's first lane. */
template <class Part, class D, class Make>
HWY_INLINE hn::Vec<D> combined(D d, const Make& part, int64_t i = 0) {
  if constexpr (hn::MaxLanes(D()) <= hn::MaxLanes(Part())) {
    return part(i);
  } else {
    const hn::Half<D> half;
    const auto low = combined<Part>(half, part, i);
    return hn::Combine(d, combined<Part>(half, part, i + static_cast<int64_t>(hn::MaxLanes(half))), low);
  }
}

}  // namespace chiasm::kernels

#if HWY_TARGET == HWY_AVX2
#include "lanes_avx2.h"
#endif
