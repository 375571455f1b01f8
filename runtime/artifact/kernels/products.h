// Sums of products of rows with panels of columns, kept in registers: matrix products, and convolutions, whose
// rows are pieces of an image.
//
// Each sum is taken in the order of the rows' values, one after another, so that it is the same whatever stands
// beside it, in however many threads, and with vectors of every length, where the CPU multiplies and adds in one
// step.
#pragma once

#include <algorithm>
#include <cstdint>
#include <type_traits>

#include "lanes.h"

namespace chiasm::kernels {

/** The columns that stand side by side: value k of column n is panel[k * kPanel + n]. */
constexpr int64_t kPanel = 16;

/** What is computed at once: as many sums as leave registers for the factors. */
template <class T>
struct Block {
  static constexpr bool kManyRegisters = HWY_TARGET <= HWY_AVX3 || HWY_ARCH_ARM_A64;  // 32, or else 16
  static constexpr int64_t kVectors = kManyRegisters ? 2 : std::clamp<int64_t>(kPanel / kLanes<T>, 1, 2);
  static constexpr int64_t kRows = (kManyRegisters ? 20 : 12) / kVectors;
  /** The panels that one vector after another goes through. */
  static constexpr int64_t kPanels = std::max<int64_t>(kVectors * kLanes<T> / kPanel, 1);
};

/** start[n] and the products of a tile's rows with the columns of so many panels, kPanels or one, which are
 *  `apart`. Each row is `pieces` pieces of `depth` values: piece i of row r begins at
 *  rows[i * kRows + r] + offset. Calls store(row, column, vector). */
template <int64_t kPanels, class T, class Store>
HWY_INLINE void multiply(const T* const* rows, int64_t pieces, int64_t depth, int64_t offset, const T* panel,
                         int64_t apart, const T* start, const Store& store) {
  constexpr int64_t lanes = kLanes<T>, height = Block<T>::kRows,
                    width = std::min(Block<T>::kVectors, kPanels * kPanel / lanes);
  const Lanes<T> d;
  for (int64_t column = 0; column < kPanels * kPanel; column += width * lanes) {
    hn::Vec<Lanes<T>> sums[height][width];
    for (auto& row : sums)
      for (int64_t v = 0; v < width; ++v) row[v] = hn::LoadU(d, start + column + v * lanes);
    const T* factors = panel + column;
    for (int64_t piece = 0; piece < pieces; ++piece) {
      const T* sources[height];
      for (int64_t r = 0; r < height; ++r) sources[r] = rows[piece * height + r] + offset;
      for (int64_t k = 0; k < depth; ++k, factors += kPanel) {
        hn::Vec<Lanes<T>> columns[width];
        for (int64_t v = 0; v < width; ++v)
          columns[v] = hn::LoadU(d, factors + v * lanes / kPanel * apart + v * lanes % kPanel);
#pragma GCC unroll 20
        for (int64_t r = 0; r < height; ++r) {
          const auto value = hn::Set(d, sources[r][k]);
#pragma GCC unroll 2
          for (int64_t v = 0; v < width; ++v) sums[r][v] = hn::MulAdd(value, columns[v], sums[r][v]);
        }
      }
    }
#pragma GCC unroll 20  // an array whose indices are known is in registers
    for (int64_t r = 0; r < height; ++r)
#pragma GCC unroll 2
      for (int64_t v = 0; v < width; ++v) store(r, column + v * lanes, sums[r][v]);
  }
}

/** body(panels, first) for all panels of begin..end: as many at once as multiply() takes, then one by one. */
template <class T, class Body>
HWY_INLINE void multiply_panels(int64_t begin, int64_t end, const Body& body) {
  constexpr std::integral_constant<int64_t, Block<T>::kPanels> several;
  constexpr std::integral_constant<int64_t, 1> one;
  if constexpr (several > 1)
    for (; begin + several <= end; begin += several) body(several, begin);
  for (; begin < end; ++begin) body(one, begin);
}

/** The first `count` values of a vector. */
template <class T>
HWY_INLINE void store_first(hn::Vec<Lanes<T>> values, T* out, int64_t count) {
  const Lanes<T> d;
  if (count >= kLanes<T>) return hn::StoreU(values, d, out);
  if (count <= 0) return;
  T all[kLanes<T>];
  hn::StoreU(values, d, all);
  std::copy_n(all, count, out);
}

}  // namespace chiasm::kernels
