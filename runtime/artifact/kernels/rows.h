// Shared code of kernels that stream over an image's rows: borders, and the split of the work.
#pragma once

#include <omp.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <new>
#include <vector>

#include "declared/types.h"
#include "lanes.h"

namespace chiasm::kernels {

// The position in 0..size-1 from which `i` takes its value, or -1 for the constant beyond the image.
inline int64_t inside(int64_t i, int64_t size, Border border) {
  if (i >= 0 && i < size) return i;
  switch (border) {
    case Border::kConstant: return -1;
    case Border::kReplicate: return i < 0 ? 0 : size - 1;
    case Border::kCircular: return ((i % size) + size) % size;
    case Border::kReflect: break;
  }
  if (size == 1) return 0;
  const int64_t period = 2 * (size - 1), mirrored = i < 0 ? -i : period - i;
  if (mirrored >= 0 && mirrored < size) return mirrored;
  const int64_t j = ((i % period) + period) % period;
  return j < size ? j : period - j;
}

// A part of a plane: some rows of a strip of columns.
struct Tile {
  int64_t plane, top, bottom, left, right;
};

// The bytes of a cache line, and a number of values rounded up to whole lines: vectors that cross from one
// line into the next take two loads or stores.
constexpr size_t kLine = 64;
template <class T>
constexpr int64_t whole_lines(int64_t values) {
  constexpr auto each = static_cast<int64_t>(kLine / sizeof(T));
  return (values + each - 1) / each * each;
}

// Memory that is aligned to a cache line.
struct ReleaseLines {
  void operator()(void* p) const { ::operator delete(p, std::align_val_t(kLine)); }
};
template <class T>
std::unique_ptr<T[], ReleaseLines> new_lines(int64_t values) {
  return std::unique_ptr<T[], ReleaseLines>(
      static_cast<T*>(::operator new(sizeof(T) * static_cast<size_t>(values), std::align_val_t(kLine))));
}

// The length of a row in scratch: a strip's columns with `ends` more, and room for vectors that run over the
// end.
template <class T>
constexpr int64_t padded_length(int64_t columns, int64_t ends) {
  return whole_lines<T>(columns + ends + 2 * kLanes<T>);
}

// The rows of a tile. Kernels with tall windows take more, else a tile would read more rows around it than in
// it.
constexpr int64_t kTileRows = 64;

// Calls body(tile, scratch, length) for tiles of `most_rows` rows that cover all planes. Strips are so wide
// that `rows` rows of one, of image and scratch together, fit into L2; strips narrow enough for L1 are
// slower, because their rows are short runs of memory. `scratch` has room for `scratch_rows` rows of
// `length`, a strip's columns and `ends` more; each row is aligned to a cache line. A strip begins with a
// whole pixel. A circular border needs both ends of a row and so whole rows.
template <class T, class Body>
void for_tiles(const Planes& planes, int64_t rows, int64_t scratch_rows, int64_t ends, Border border,
               const Body& body, int64_t most_rows = kTileRows) {
  constexpr int64_t kCache = 262144;
  const int64_t step = 64 * planes.step;
  if (planes.count * planes.height * planes.width == 0) return;
  int64_t strips = planes.width * rows * static_cast<int64_t>(sizeof(T)) / kCache + 1;
  int64_t columns = ((planes.width + strips - 1) / strips + step - 1) / step * step;
  if (border == Border::kCircular || columns < 4 * ends || columns > planes.width) columns = planes.width;
  strips = (planes.width + columns - 1) / columns;
  const int64_t blocks = (planes.height + most_rows - 1) / most_rows,
                length = padded_length<T>(columns, ends);
  // Allocated here, because nothing may be thrown inside the parallel region.
  const auto scratch = new_lines<T>(scratch_rows * length * omp_get_max_threads());
#pragma omp parallel
  {
    T* const own = scratch.get() + scratch_rows * length * omp_get_thread_num();
#pragma omp for
    for (int64_t i = 0; i < planes.count * strips * blocks; ++i) {
      const int64_t top = i % blocks * most_rows, left = i / blocks % strips * columns;
      const Tile tile{i / blocks / strips, top, std::min(top + most_rows, planes.height), left,
                      std::min(left + columns, planes.width)};
      body(tile, own, length);
    }
  }
}

/** for_lanes over a row that is in the cache, while it prefetches the `next` row that is read or written.
 *  Loops that fill scratch from an image prefetch the row of the output, and loops that fill the output
 *  prefetch the next row of the image: otherwise memory would be idle during the loop. */
template <class T, int kVectors = 1, bool again = false, class Body>
HWY_INLINE void for_lanes_fetching(int64_t n, const T* next, const Body& body) {
  constexpr int64_t kEach = whole_lines<T>(1);
  constexpr int kBlock = std::max<int>(kVectors, kEach / kLanes<T>);  // a line, to prefetch it only once
  for_lanes<T, kBlock, again>(n, [=](auto d, auto vectors, int64_t k) {
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    if constexpr (decltype(vectors)::value == kBlock) {
      for (int64_t i = 0; i < kBlock * lanes; i += kEach) hwy::Prefetch(next + k + i);
      for (int v = 0; v < kBlock; v += kVectors)
        body(d, std::integral_constant<int, kVectors>(), k + v * lanes);
    } else {
      body(d, vectors, k);
    }
  });
}

// Fills the part of a tile's row that is beyond the image. `row` points to the tile's first column; `before`
// and `after` values around the tile are needed, which are whole pixels.
template <class T>
inline void extend(T* row, const Tile& tile, int64_t width, int64_t before, int64_t after, Border border,
                   T value, int64_t step = 1) {
  const auto extend_by = [&](auto each) {
    const int64_t pixels = width / each;
    const auto fill = [&](int64_t pixel) {
      const int64_t source = inside(pixel, pixels, border);
      T* const to = row + pixel * each - tile.left;
      const T* const from = row + source * each - tile.left;
      for (int64_t c = 0; c < each; ++c) to[c] = source < 0 ? value : from[c];
    };
    for (int64_t i = (tile.left - before) / each; i < 0; ++i) fill(i);
    for (int64_t i = pixels; i < (tile.right + after) / each; ++i) fill(i);
  };
  // The divisions, which planes do not need, take longer than a short row.
  if (step == 1)
    extend_by(std::integral_constant<int64_t, 1>());
  else
    extend_by(step);
}

// The tile's columns of row y of a plane, or of its last row, for prefetching.
template <class T>
T* tile_row(T* plane, const Planes& planes, const Tile& tile, int64_t y) {
  return plane + std::clamp<int64_t>(y, 0, planes.height - 1) * planes.width + tile.left;
}

// The columns inside the image that a tile needs with `before` and `after` more.
struct Span {
  int64_t first, last;
  Span(const Tile& tile, int64_t width, int64_t before, int64_t after)
      : first(std::max<int64_t>(tile.left - before, 0)), last(std::min(tile.right + after, width)) {}
  int64_t count() const { return last - first; }
};

/** The rows of a tile as a window of kh x kw pixels that begins (row, column) before its pixel sees them: a
 *  ring of kh padded rows, `ends(...)` values longer than the tile's. Bytes become numbers of type T. */
template <class T, class Pixel = T>
class PaddedRows {
 public:
  PaddedRows(const Pixel* plane, const Planes& planes, const Tile& tile, Border border, T value, int64_t kh,
             int64_t kw, int64_t row, int64_t column, T* ring, int64_t length)
      : plane_(plane),
        planes_(planes),
        tile_(tile),
        border_(border),
        value_(value),
        kh_(kh),
        row_(row),
        margin_(ends(planes, kw, column) / 2),
        first_(margin_ - column * planes.step),
        ring_(ring),
        length_(length) {
    for (int64_t i = 0; i + 1 < kh; ++i) fetch(tile.top - row + i, tile_row(plane, planes, tile, tile.top));
  }

  // The same on both sides, so that even a narrow strip contains the pixels that it mirrors.
  static int64_t ends(const Planes& planes, int64_t kw, int64_t column) {
    return 2 * std::max(column, kw - 1 - column) * planes.step;
  }

  /** Puts the last row of the windows of row y into the ring, for each y from the tile's top on, and
   *  prefetches the row `next`. Returns the row of the image to prefetch after it. */
  const Pixel* advance(int64_t y, const Pixel* next) const {
    const int64_t last = y - row_ + kh_ - 1;
    fetch(last, next);
    return tile_row(plane_, planes_, tile_, last + 1);
  }

  /** Pixel (i, j) of the window of the first pixel of row y; those of the pixels to the right are next to
   *  it. */
  const T* at(int64_t y, int64_t i, int64_t j) const {
    return place(y - row_ + i) + first_ + j * planes_.step;
  }

 private:
  T* place(int64_t y) const { return ring_ + (y + kh_) % kh_ * length_; }

  void fetch(int64_t y, const Pixel* next) const {
    T* const p = place(y);
    const int64_t source = inside(y, planes_.height, border_);
    if (source < 0) {
      std::fill_n(p, tile_.right - tile_.left + 2 * margin_, value_);
      return;
    }
    const Span span(tile_, planes_.width, margin_, margin_);
    copy(plane_ + source * planes_.width + span.first, span.count(), p + margin_ + span.first - tile_.left,
         next);
    extend(p + margin_, tile_, planes_.width, margin_, margin_, border_, value_, planes_.step);
  }

  static void copy(const Pixel* x, int64_t n, T* out, const Pixel* next) {
    if constexpr (std::is_same_v<Pixel, T>)
      for_lanes_fetching<T>(n, next,
                            [=](auto d, auto, int64_t k) { hn::StoreU(hn::LoadU(d, x + k), d, out + k); });
    else
      for_lanes<T>(n, [=](auto d, auto, int64_t k) {
        const hn::Rebind<Pixel, decltype(d)> pixels;
        const auto whole = hn::PromoteTo(Integers<decltype(d)>(), hn::LoadU(pixels, x + k));
        hn::StoreU(hn::ConvertTo(d, whole), d, out + k);
      });
  }

  const Pixel* const plane_;
  const Planes planes_;
  const Tile tile_;
  const Border border_;
  const T value_;
  const int64_t kh_, row_, margin_, first_;
  T* const ring_;
  const int64_t length_;
};

}  // namespace chiasm::kernels
