// Included by every compiled loop of an op (python/chiasm/export/patches/index_checks.py), for the cases in
// which AOTInductor's own code has undefined behaviour or ends the process. If data contain an index or a
// divisor that is not allowed, the error is noted for the run and a harmless value is used instead: no loop
// reads or writes outside of its tensors, no exception leaves a parallel region, and the run returns the
// error.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace chiasm {

#ifdef CHIASM_CHECKS_THROW
// Code that needs libtorch runs in its loader, which has no place for a note. Its loops have one thread each.
[[noreturn, gnu::cold, gnu::noinline]] inline void note_index(int64_t index, int64_t size,
                                                              const char* reader) {
  throw std::out_of_range("index " + std::to_string(index) + " is out of range for an axis of size " +
                          std::to_string(size) + " (" + reader + ")");
}
[[noreturn, gnu::cold, gnu::noinline]] inline void note_division() {
  throw std::domain_error("an integer was divided by zero");
}
#else
// Note the error for the run that this thread works for; the first one counts. In aoti/errors.cpp.
[[gnu::cold, gnu::noinline]] void note_index(int64_t index, int64_t size, const char* reader);
[[gnu::cold, gnu::noinline]] void note_division();
#endif

// `index`, or 0 if it is outside of [0, size). With `wrapped`, `size` was already added to negative indices.
// `reader` names the operation that uses the index. Without `active` the index is not used.
template <bool wrapped, class T>
inline T checked_index(T index, int64_t size, const char* reader, bool active = true) {
  static_assert(std::is_integral_v<T>);
  // Hides from the compiler how the index was computed: if that was undefined (the conversion of NaN), it
  // could remove the check.
  asm("" : "+r"(index));
  if (static_cast<uint64_t>(static_cast<int64_t>(index)) < static_cast<uint64_t>(size)) [[likely]]
    return index;
  if (active) note_index(wrapped && index < 0 ? index - size : index, size, reader);
  return 0;
}

// A vector's element type and number of lanes.
template <class V>
struct Lanes;

#if INDUCTOR_USE_VECTOR_TYPES()
template <class T>
struct Lanes<at::vec::Vectorized<T>> {
  using Value = T;
  static constexpr int count = at::vec::Vectorized<T>::size(), parts = 1;
};
template <class T, int n>
struct Lanes<at::vec::VectorizedN<T, n>> {
  using Value = T;
  static constexpr int count = at::vec::VectorizedN<T, n>::size(), parts = n;
};

// The same for a vector: only the first `used` lanes are read, and of these only those for which `active(i)`
// is true must be valid.
template <bool wrapped, class V, class Active>
inline V checked_index(const V& index, int64_t size, const char* reader, int used, Active active) {
  using T = typename Lanes<V>::Value;
  const int64_t most = size - 1 < std::numeric_limits<T>::max() ? size - 1 : std::numeric_limits<T>::max();
  const V safe = at::vec::minimum(at::vec::maximum(index, V(T(0))), V(static_cast<T>(most)));
  const auto differs = at::vec::VecMask<T, Lanes<V>::parts>(safe != index);
  if (!differs.all_zero()) [[unlikely]] {
    T lanes[Lanes<V>::count];
    index.store(lanes);
    for (int i = 0; i < used; ++i) checked_index<wrapped>(lanes[i], size, reader, active(i));
  }
  return safe;
}

template <bool wrapped, class V>
inline V checked_index(const V& index, int64_t size, const char* reader, int used) {
  return checked_index<wrapped>(index, size, reader, used, [](int) { return true; });
}
// Minima and maxima (python/chiasm/export/patches/inductor.py: `short_minima`) for which minima_avx2.h has no
// shorter form: those that pass NaN on, and those of values that are not NaN.
using at::vec::maximum;
using at::vec::minimum;
template <class V>
inline V smaller(const V& a, const V& b) {
  return at::vec::minimum(a, b);
}
template <class V>
inline V larger(const V& a, const V& b) {
  return at::vec::maximum(a, b);
}
#endif

// Quotients and remainders of integers, for divisors that may be zero and for the one quotient that overflows
// (it traps on x86, and wraps here). `body` gets operands that are safe to divide.
template <class T, class Body>
inline T divided(T a, T b, Body body) {
  if (b == 0) [[unlikely]] {
    note_division();
    return 0;
  }
  if constexpr (std::is_signed_v<T>) {
    if (b == T(-1)) [[unlikely]]
      return body(static_cast<T>(0 - static_cast<std::make_unsigned_t<T>>(a)), T(1));
  }
  return body(a, b);
}

template <class A, class B, class Body>
inline auto divided_each(const A& a, const B& b, Body body) {
  if constexpr (std::is_arithmetic_v<A>) {
    using T = std::common_type_t<A, B>;
    return divided(static_cast<T>(a), static_cast<T>(b), body);
  } else {
    using T = typename Lanes<A>::Value;
    T left[Lanes<A>::count], right[Lanes<A>::count];
    a.store(left);
    b.store(right);
    for (int i = 0; i < Lanes<A>::count; ++i) left[i] = divided(left[i], right[i], body);
    return A::loadu(left);
  }
}

template <class A, class B>
inline auto floor_divide_integral(const A& a, const B& b) {
  return divided_each(
      a, b, [](auto x, auto y) -> decltype(x) { return x / y - ((x % y != 0) && ((x < 0) != (y < 0))); });
}

template <class A, class B>
inline auto truncated_quotient(const A& a, const B& b) {
  return divided_each(a, b, [](auto x, auto y) -> decltype(x) { return x / y; });
}

// The remainder that has the dividend's sign.
template <class A, class B>
inline auto mod(const A& a, const B& b) {
  if constexpr (std::is_floating_point_v<A> || std::is_floating_point_v<B>)
    return std::fmod(a, b);
  else
    return divided_each(a, b, [](auto x, auto y) -> decltype(x) { return x % y; });
}

// The remainder that has the divisor's sign. With a divisor of -1 it is 0.
template <class A, class B>
inline auto remainder_integral(const A& a, const B& b) {
  return divided_each(a, b, [](auto x, auto y) -> decltype(x) {
    const auto rest = x % y;
    return rest != 0 && ((rest < 0) != (y < 0)) ? rest + y : rest;
  });
}

}  // namespace chiasm

#if INDUCTOR_USE_VECTOR_TYPES() && defined(CPU_CAPABILITY_AVX2) && !defined(CHIASM_CHECKS_THROW)
#include "minima_avx2.h"
#endif
