// What kernels that stream over an image's rows share: borders, and the split of the work.
#pragma once

#include <omp.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "kernels.h"
#include "lanes.h"

namespace chiasm::kernels {

// The position inside 0..size-1 that `i` stands for, or -1 where it is the constant beyond the image.
inline int64_t inside(int64_t i, int64_t size, Border border) {
  if (i >= 0 && i < size) return i;
  switch (border) {
    case Border::kConstant: return -1;
    case Border::kReplicate: return i < 0 ? 0 : size - 1;
    case Border::kCircular: return ((i % size) + size) % size;
    case Border::kReflect: break;
  }
  if (size == 1) return 0;
  const int64_t period = 2 * (size - 1), j = ((i % period) + period) % period;
  return j < size ? j : period - j;
}

// A part of a plane: some rows of a strip of columns.
struct Tile {
  int64_t plane, top, bottom, left, right;
};

// The length of a row in scratch: a strip's columns with `ends` more, and room for vectors that run over the end.
template <class T>
constexpr int64_t padded_length(int64_t columns, int64_t ends) {
  return columns + ends + 2 * kLanes<T>;
}

// Calls body(tile, scratch, length) for tiles that cover all planes. `rows` rows of a strip, of image and scratch, fit into the second
// cache together; strips narrow enough for the first are slower, because their rows are short runs of memory. `scratch` has room
// for `scratch_rows` rows of `length`: a strip's columns and `ends` more. A circular border needs both ends of a row and so whole rows.
template <class T, class Body>
void for_tiles(const Planes& planes, int64_t rows, int64_t scratch_rows, int64_t ends, Border border, const Body& body) {
  constexpr int64_t kRows = 64, kCache = 262144, kStep = 64;
  if (planes.count * planes.height * planes.width == 0) return;
  int64_t strips = planes.width * rows * static_cast<int64_t>(sizeof(T)) / kCache + 1;
  int64_t columns = ((planes.width + strips - 1) / strips + kStep - 1) / kStep * kStep;
  if (border == Border::kCircular || columns < 4 * ends || columns > planes.width) columns = planes.width;
  strips = (planes.width + columns - 1) / columns;
  const int64_t blocks = (planes.height + kRows - 1) / kRows, length = padded_length<T>(columns, ends);
  // Allocated here, because nothing may be thrown inside the parallel region.
  const std::unique_ptr<T[]> scratch(new T[static_cast<size_t>(scratch_rows * length * omp_get_max_threads())]);
#pragma omp parallel
  {
    T* const own = scratch.get() + scratch_rows * length * omp_get_thread_num();
#pragma omp for
    for (int64_t i = 0; i < planes.count * strips * blocks; ++i) {
      const int64_t top = i % blocks * kRows, left = i / blocks % strips * columns;
      const Tile tile{i / blocks / strips, top, std::min(top + kRows, planes.height), left, std::min(left + columns, planes.width)};
      body(tile, own, length);
    }
  }
}

// Fills what a tile's row has beyond the image: `row` points to the tile's first column, of which `before` and `after` more are needed.
template <class T>
inline void extend(T* row, const Tile& tile, int64_t width, int64_t before, int64_t after, Border border, T value) {
  const auto fill = [&](int64_t i) {
    const int64_t j = inside(i, width, border);
    row[i - tile.left] = j < 0 ? value : row[j - tile.left];
  };
  for (int64_t i = tile.left - before; i < 0; ++i) fill(i);
  for (int64_t i = width; i < tile.right + after; ++i) fill(i);
}

// The columns inside the image that a tile needs with `before` and `after` more.
struct Span {
  int64_t first, last;
  Span(const Tile& tile, int64_t width, int64_t before, int64_t after)
      : first(std::max<int64_t>(tile.left - before, 0)), last(std::min(tile.right + after, width)) {}
  int64_t count() const { return last - first; }
};

}  // namespace chiasm::kernels
