// The largest or smallest values of rows, in order. NaN sorts as the largest value, as in PyTorch; equal
// values keep their order, so that every backend picks the same ones.
#pragma once

#include <omp.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <numeric>
#include <type_traits>
#include <utility>

namespace chiasm::artifact {

template <class T>
using Key = std::conditional_t<sizeof(T) == 8, uint64_t, uint32_t>;

// A key that orders all values of a type: of two values the one that is taken first has the smaller key.
template <class T>
Key<T> sort_key(T value, bool largest) {
  constexpr Key<T> kSign = Key<T>{1} << (8 * sizeof(T) - 1);
  Key<T> key;
  if (value != value) {
    key = ~Key<T>{0};
  } else {
    if (value == T(0)) value = T(0);  // -0 equals 0
    std::memcpy(&key, &value, sizeof key);
    const bool descends =
        std::is_floating_point_v<T> && (key & kSign) != 0;  // negative numbers are ordered by magnitude
    key ^= descends ? ~Key<T>{0} : kSign;
  }
  return largest ? ~key : key;
}

template <class T>
struct Keyed {
  Key<T> key;
  uint32_t place;
};

// Orders `items` by their keys, digit by digit from the lowest, each in a pass that keeps the order of equals
// (D. Knuth, The Art of Computer Programming 3, 5.2.5, algorithm R). A digit that all have in common needs no
// pass. `other` has room for as many items. Returns one of the two arrays.
template <class T>
Keyed<T>* sort_by_digits(Keyed<T>* items, Keyed<T>* other, int64_t n) {
  constexpr int kBits = 11, kDigits = (8 * sizeof(Key<T>) + kBits - 1) / kBits;
  constexpr Key<T> kMask = (Key<T>{1} << kBits) - 1;
  std::array<std::array<uint32_t, kMask + 1>, kDigits> counts{};
  for (int64_t i = 0; i < n; ++i)
    for (int d = 0; d < kDigits; ++d) ++counts[d][(items[i].key >> (d * kBits)) & kMask];
  for (int d = 0; d < kDigits; ++d) {
    auto& count = counts[d];
    const auto digit = [&](const Keyed<T>& item) { return (item.key >> (d * kBits)) & kMask; };
    if (count[digit(items[0])] == n) continue;
    uint32_t before = 0;
    for (uint32_t& each : count) before += std::exchange(each, before);
    for (int64_t i = 0; i < n; ++i) other[count[digit(items[i])]++] = items[i];
    std::swap(items, other);
  }
  return items;
}

// The indices of the first k of a row of n, in order.
template <class T>
void first_places(const T* values, int64_t n, int64_t k, bool largest, int64_t* order) {
  std::iota(order, order + n, 0);
  std::partial_sort(order, order + k, order + n, [&](int64_t a, int64_t b) {
    const auto x = sort_key(values[a], largest), y = sort_key(values[b], largest);
    return x != y ? x < y : a < b;
  });
}

// The k largest or smallest of each of `rows` rows of n, and their indices.
template <class T>
void topk_rows(const T* values, int64_t rows, int64_t n, int64_t k, bool largest, T* top, int64_t* index) {
  // A small heap compares most values only once. Below a thousand values, counting digits takes most of the
  // time.
  const bool by_digits = k >= n / 16 && n >= 1024 && n <= int64_t{UINT32_MAX};
  // Each part has scratch of its own. Allocated here, because nothing may be thrown inside the parallel
  // region.
  const int64_t parts = std::min<int64_t>(omp_get_max_threads(), rows);
  const std::unique_ptr<Keyed<T>[]> items(by_digits ? new Keyed<T>[2 * n * parts] : nullptr);
  const std::unique_ptr<int64_t[]> orders(by_digits ? nullptr : new int64_t[n * parts]);
#pragma omp parallel for
  for (int64_t part = 0; part < parts; ++part)
    for (int64_t row = part; row < rows; row += parts) {
      const T* const from = values + row * n;
      int64_t* const places = index + row * k;
      if (by_digits) {
        Keyed<T>* const own = items.get() + 2 * n * part;
        for (int64_t i = 0; i < n; ++i) own[i] = {sort_key(from[i], largest), static_cast<uint32_t>(i)};
        const Keyed<T>* const sorted = sort_by_digits<T>(own, own + n, n);
        for (int64_t i = 0; i < k; ++i) places[i] = sorted[i].place;
      } else {
        int64_t* const order = orders.get() + n * part;
        first_places(from, n, k, largest, order);
        std::copy(order, order + k, places);
      }
      for (int64_t i = 0; i < k; ++i) top[row * k + i] = from[places[i]];
    }
}

}  // namespace chiasm::artifact
