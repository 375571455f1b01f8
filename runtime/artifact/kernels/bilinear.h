// Reads images at runs of positions bilinearly.
#pragma once

#include <cstring>

#include "positions.h"

namespace chiasm::kernels {

// What a run of positions reads. A pair of neighbours in a row is loaded together, so the two weights of a
// pair are adjacent; in a vector of positions, the pairs of the even positions come before those of the odd
// ones. If all pairs of a vector of positions lie in one vector of pixels and the next pixel (`near`, two
// loads), the weights of all first pixels come before those of all second pixels.
template <class T>
struct Neighbours {
  alignas(64) int32_t index[kRun];
  alignas(64) T upper[2 * kRun], lower[2 * kRun];
  bool near[kRun / kLanes<T>];
};

// For each position the first pixel of the pair to read along an axis, and the weights of both, 0 for pixels
// outside.
template <class T>
inline void pair_up(const T* x, int64_t n, int64_t size, int32_t* first, T* weight0, T* weight1) {
  const Lanes<T> d;
  const auto all = [=](auto value) { return hn::Set(d, static_cast<T>(value)); };
  const auto zero = all(0), one = all(1), end = all(size - 1), last = all(std::max<int64_t>(size - 2, 0)),
             least = all(-2), greatest = all(size + 1);
  const auto put = [=](int64_t i, auto from, auto weight_of_first, auto weight_of_second) {
    hn::StoreU(truncated(d, from), Integers<Lanes<T>>(), first + i);
    hn::StoreU(weight_of_first, d, weight0 + i);
    hn::StoreU(weight_of_second, d, weight1 + i);
  };
  for (int64_t i = 0; i < n; i += kLanes<T>) {
    const auto given = hn::LoadU(d, x + i);
    if (size > 1 && hn::AllTrue(d, hn::And(hn::Ge(given, zero), hn::Le(given, end)))) {
      const auto from = smaller(hn::Floor(given), last), fraction = hn::Sub(given, from);
      put(i, from, hn::Sub(one, fraction), fraction);
      continue;
    }
    // positions further outside, and NaN, get weights of 0 too
    const auto position = smaller(larger(given, least), greatest);
    const auto pixel = hn::Floor(position), fraction = hn::Sub(position, pixel),
               from = smaller(larger(pixel, zero), last);
    const auto near =
        hn::IfThenElseZero(hn::And(hn::Ge(pixel, zero), hn::Le(pixel, end)), hn::Sub(one, fraction));
    const auto far = hn::IfThenElseZero(hn::And(hn::Ge(pixel, hn::Neg(one)), hn::Lt(pixel, end)), fraction);
    // Left of the image, the second neighbour is the pair's first pixel; at the last pixel, the first
    // neighbour is the pair's second.
    const auto same = hn::Eq(pixel, from);
    put(i, from, hn::Add(hn::IfThenElseZero(same, near), hn::IfThenElseZero(hn::Lt(pixel, from), far)),
        hn::Add(hn::IfThenElseZero(same, far), hn::IfThenElseZero(hn::Gt(pixel, from), near)));
  }
}

// Where `rest` is given, it gets what the weights of each position lack to 1.
template <class T>
inline void bilinear_taps(const T* x, const T* y, int64_t n, int64_t height, int64_t width, int64_t stride,
                          Neighbours<T>& taps, T* rest = nullptr) {
  const Lanes<T> d;
  constexpr int64_t lanes = kLanes<T>;
  int32_t column[kRun], row[kRun];
  T left[kRun], right[kRun], top[kRun], bottom[kRun];
  pair_up(x, n, width, column, left, right);
  pair_up(y, n, height, row, top, bottom);
  for (int64_t i = 0; i < n; ++i) taps.index[i] = row[i] * static_cast<int32_t>(stride) + column[i];
  // the last index at which a vector and one more pixel can be loaded in this row and the next
  const int64_t last = (height - 2) * stride + width - lanes - 1;
  for (int64_t i = 0; i < n; i += lanes) {
    const auto at = [=](const T* weights) { return hn::LoadU(d, weights + i); };
    const auto first = at(left), second = at(right), above = at(top), below = at(bottom);
    if (rest != nullptr) {
      auto sum = hn::Add(hn::Mul(above, first), hn::Mul(above, second));
      sum = hn::Add(hn::Add(sum, hn::Mul(below, first)), hn::Mul(below, second));
      hn::StoreU(hn::Sub(hn::Set(d, T(1)), sum), d, rest + i);
    }
    bool near = false;
    if constexpr (sizeof(T) == sizeof(float))
      near = i + lanes <= n && taps.index[i] <= last && in_one_vector(from_first(taps.index + i));
    taps.near[i / lanes] = near;
    T *const upper = taps.upper + 2 * i, *const lower = taps.lower + 2 * i;
    if (near) {
      hn::StoreU(hn::Mul(above, first), d, upper);
      hn::StoreU(hn::Mul(above, second), d, upper + lanes);
      hn::StoreU(hn::Mul(below, first), d, lower);
      hn::StoreU(hn::Mul(below, second), d, lower + lanes);
    } else {
      const auto even = hn::OddEven(hn::DupEven(second), first), odd = hn::OddEven(second, hn::DupOdd(first));
      hn::StoreU(hn::Mul(hn::DupEven(above), even), d, upper);
      hn::StoreU(hn::Mul(hn::DupOdd(above), odd), d, upper + lanes);
      hn::StoreU(hn::Mul(hn::DupEven(below), even), d, lower);
      hn::StoreU(hn::Mul(hn::DupOdd(below), odd), d, lower + lanes);
    }
  }
}

// The pairs of pixels at every second position.
template <class D, class T>
HWY_INLINE hn::Vec<D> pairs(D d, const T* p, const int32_t* index) {
  const hn::FixedTag<T, 16 / sizeof(T)> part;
  return combined<decltype(part)>(d, [=](int64_t i) {
    if constexpr (sizeof(T) == sizeof(double)) {
      return hn::LoadU(part, p + index[i]);
    } else {
      double first, second;  // two pixels each, at any address
      std::memcpy(&first, p + index[i], sizeof first);
      std::memcpy(&second, p + index[i + 2], sizeof second);
      const hn::FixedTag<double, 2> two;
      return hn::BitCast(part, hn::OddEven(hn::Set(two, second), hn::Set(two, first)));
    }
  });
}

// Adds up the pairs. Those of even positions are in one vector, those of odd positions in the other.
template <class D>
HWY_INLINE hn::Vec<D> sum_pairs(D d, hn::Vec<D> even, hn::Vec<D> odd) {
  return hn::Add(hn::OddEven(odd, even), hn::Reverse2(d, hn::OddEven(even, odd)));
}

template <class T>
inline void bilinear(const T* plane, int64_t stride, const Neighbours<T>& taps, int64_t n, T* out) {
  const Lanes<T> d;
  constexpr int64_t lanes = kLanes<T>;
  const T* const below = plane + stride;
  int64_t i = 0;
  for (; i + lanes <= n; i += lanes) {
    if constexpr (sizeof(T) == sizeof(float)) {
      if (taps.near[i / lanes]) {
        const auto from = hn::IndicesFromVec(d, from_first(taps.index + i));
        const T *const a = plane + taps.index[i], *const b = a + stride, *const upper = taps.upper + 2 * i,
                       *const lower = taps.lower + 2 * i;
        const auto product = [=](const T* pixels, const T* weights) {
          return hn::Mul(hn::TableLookupLanes(hn::LoadU(d, pixels), from), hn::LoadU(d, weights));
        };
        const auto first = hn::Add(product(a, upper), product(b, lower)),
                   second = hn::Add(product(a + 1, upper + lanes), product(b + 1, lower + lanes));
        hn::StoreU(hn::Add(first, second), d, out + i);
        continue;
      }
    }
    const auto weighed = [=, &taps](int64_t first, int64_t k) {
      const int32_t* const index = taps.index + first;
      return hn::Add(hn::Mul(pairs(d, plane, index), hn::LoadU(d, taps.upper + k)),
                     hn::Mul(pairs(d, below, index), hn::LoadU(d, taps.lower + k)));
    };
    hn::StoreU(sum_pairs(d, weighed(i, 2 * i), weighed(i + 1, 2 * i + lanes)), d, out + i);
  }
  for (; i < n; ++i) {
    const T *const a = plane + taps.index[i], *const b = below + taps.index[i];
    // the index of the pair's weights
    const int64_t k = 2 * (i / lanes * lanes) + i % 2 * lanes + i % lanes / 2 * 2;
    out[i] =
        (a[0] * taps.upper[k] + b[0] * taps.lower[k]) + (a[1] * taps.upper[k + 1] + b[1] * taps.lower[k + 1]);
  }
}

}  // namespace chiasm::kernels
