// Pixels of 16 bits as numbers.
#pragma once

#include <type_traits>

#include "rows.h"

namespace chiasm::kernels {

/** Words as numbers in double. */
template <class D, class Word>
HWY_INLINE hn::Vec<D> numbers_of(D numbers, const Word* x) {
  const hn::Rebind<Word, D> words;
  return hn::PromoteTo(numbers, hn::PromoteTo(Integers<D>(), hn::LoadU(words, x)));
}

/** The first and the second of two words in an integer. */
template <class Word, class D>
HWY_INLINE hn::Vec<D> high_half(D d, hn::Vec<D> both) {
  if constexpr (std::is_signed_v<Word>)
    return hn::ShiftRight<16>(both);
  else
    return hn::And(hn::ShiftRight<16>(both), hn::Set(d, 0xFFFF));
}

template <class Word, class D>
HWY_INLINE hn::Vec<D> low_half(D d, hn::Vec<D> both) {
  if constexpr (std::is_signed_v<Word>)
    return hn::ShiftRight<16>(hn::ShiftLeft<16>(both));
  else
    return hn::And(both, hn::Set(d, 0xFFFF));
}

}  // namespace chiasm::kernels
