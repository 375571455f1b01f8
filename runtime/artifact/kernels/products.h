// Register-tiled products of rows with packed panels of columns. For matrix products, and for convolutions,
// in which a row consists of pieces of an image.
//
// Each sum has one accumulator and is taken in the order of k. A result is therefore the same for every batch
// size and number of threads, and for every vector length on CPUs with fused multiply-add.
#pragma once

#include <algorithm>
#include <cstdint>
#include <type_traits>

#include "lanes.h"

namespace chiasm::kernels {

/** Columns of a panel: value k of column n is panel[k * kPanel + n]. */
constexpr int64_t kPanel = 16;

/** How many rows of a panel ahead the loop prefetches: weights are read once, from memory. */
constexpr int64_t kAhead = 32;

/** The tile of sums that fits in registers together with the factors. */
template <class T>
struct Block {
  static constexpr bool kManyRegisters = HWY_TARGET <= HWY_AVX3 || HWY_ARCH_ARM_A64;  // 32, otherwise 16
  static constexpr int64_t kVectors = kManyRegisters ? 2 : std::clamp<int64_t>(kPanel / kLanes<T>, 1, 2);
  static constexpr int64_t kRows = (kManyRegisters ? 20 : 12) / kVectors;
  /** Panels that a tile spans. */
  static constexpr int64_t kPanels = std::max<int64_t>(kVectors * kLanes<T> / kPanel, 1);
};

/** start[n] plus the products of Block::kRows rows with the columns of kPanels adjacent panels, `apart`
 *  values from one to the next. A row consists of `pieces` pieces of `depth` values: piece i of row r begins
 *  at rows[i * Block::kRows + r] + offset. Calls store(row, column, vector) for each vector of sums.
 *
 *  Not inline: among the variables of a caller, GCC 12 keeps some of the sums in memory. */
template <int64_t kPanels, class T, class Store>
HWY_NOINLINE void multiply(const T* const* rows, int64_t pieces, int64_t depth, int64_t offset,
                           const T* panel, int64_t apart, const T* start, const Store& store) {
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
        for (int64_t i = 0; i < kPanels; ++i) hwy::Prefetch(factors + i * apart + kAhead * kPanel);
#pragma GCC unroll 20
        for (int64_t r = 0; r < height; ++r) {
          const auto value = hn::Set(d, sources[r][k]);
#pragma GCC unroll 2
          for (int64_t v = 0; v < width; ++v) sums[r][v] = hn::MulAdd(value, columns[v], sums[r][v]);
        }
      }
    }
#pragma GCC unroll 20  // with constant indices the compiler keeps the array in registers
    for (int64_t r = 0; r < height; ++r)
#pragma GCC unroll 2
      for (int64_t v = 0; v < width; ++v) store(r, column + v * lanes, sums[r][v]);
  }
}

/** Calls body(panels, first) for the panels begin..end: Block::kPanels at once, the rest one by one. */
template <class T, class Body>
HWY_INLINE void multiply_panels(int64_t begin, int64_t end, const Body& body) {
  constexpr std::integral_constant<int64_t, Block<T>::kPanels> several;
  constexpr std::integral_constant<int64_t, 1> one;
  if constexpr (several > 1)
    for (; begin + several <= end; begin += several) body(several, begin);
  for (; begin < end; ++begin) body(one, begin);
}

/** Stores the first `count` values of a vector. */
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
