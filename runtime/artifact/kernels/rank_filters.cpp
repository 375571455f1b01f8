// Maxima, minima and medians of windows, row by row.
//
// The loops over a row are functions of their own, of values and not of references: a vector's store may
// alias anything that is behind a reference, which would be loaded again in every round.
#include "rows.h"

namespace chiasm::kernels {
namespace {

template <bool largest, class V>
HWY_INLINE V extreme(V a, V b) {
  return largest ? larger(a, b) : smaller(a, b);
}

// row[k] = the extreme of row[k] and row[k + shift], for k = 0 .. n - 1 and on to a whole vector.
template <class T, bool largest>
void double_window(T* row, int64_t shift, int64_t n) {
  const Lanes<T> d;
  for (int64_t k = 0; k < n; k += kLanes<T>)
    hn::StoreU(extreme<largest>(hn::LoadU(d, row + k), hn::LoadU(d, row + k + shift)), d, row + k);
}

template <class T>
struct Tap {
  int64_t row, column;
  T height;
};

// out[k] = the extreme of sources[t][k], plus the tap's height unless all are 0.
template <class T, bool largest, bool flat>
void extreme_of_taps(const T* const* sources, const Tap<T>* taps, int64_t count, int64_t n, T* out,
                     const T* next) {
  for_lanes_fetching<T, 4>(n, next, [=](auto d, auto vectors, int64_t k) {
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    const auto value = [=](int64_t t, int v) {
      const auto pixels = hn::LoadU(d, sources[t] + k + v * lanes);
      if constexpr (flat)
        return pixels;
      else
        return hn::Add(pixels, hn::Set(d, taps[t].height));
    };
    hn::Vec<decltype(d)> best[vectors];
    for (int v = 0; v < vectors; ++v) best[v] = value(0, v);
    for (int64_t t = 1; t < count; ++t)
      for (int v = 0; v < vectors; ++v) best[v] = extreme<largest>(best[v], value(t, v));
    for (int v = 0; v < vectors; ++v) hn::StoreU(best[v], d, out + k + v * lanes);
  });
}

// Up to this many shifts of a row are compared at once.
constexpr int64_t kAtOnce = 8;

template <class T, bool largest>
void rectangle(const T* x, const Planes& planes, int64_t ky, int64_t kx, Border border, T value, T* out) {
  const int64_t height = planes.height, width = planes.width, ry = ky / 2, rx = kx / 2;
  std::vector<const T*> all_sources(static_cast<size_t>((ky + kAtOnce) * omp_get_max_threads()));
  const int64_t lead = whole_lines<T>(rx);
  for_tiles<T>(planes, ky + 2, 2, lead + rx, border, [&](const Tile& tile, T* scratch, int64_t length) {
    const T* const image = x + tile.plane * height * width;
    const T** const rows = all_sources.data() + (ky + kAtOnce) * omp_get_thread_num();
    const T** const shifts = rows + ky;
    const Span span(tile, width, rx, rx);
    const int64_t columns = tile.right - tile.left;
    T *const buffer = scratch + lead, *const first = buffer - rx, *const constant = scratch + length;
    std::fill_n(scratch, 2 * length, value);
    // Two windows of a length make one of up to twice the length; what they share does no harm. Short ones
    // are quicker done at once, because loads that span two values just stored must wait for them.
    int64_t size = 1;
    while (size * kAtOnce < kx) size *= 2;
    int64_t count = 0;
    for (int64_t j = 0; j < kx - size; j += size) shifts[count++] = first + j;
    shifts[count++] = first + kx - size;
    for (int64_t y = tile.top; y < tile.bottom; ++y) {
      for (int64_t i = 0; i < ky; ++i) {
        const int64_t source = inside(y + i - ry, height, border);
        rows[i] = source < 0 ? constant : image + source * width + span.first;
      }
      T* const target = tile_row(out + tile.plane * height * width, planes, tile, y);
      extreme_of_taps<T, largest, true>(rows, nullptr, ky, span.count(), buffer + span.first - tile.left,
                                        target);
      extend(buffer, tile, width, rx, rx, border, value);
      for (int64_t n = 1; n < size; n *= 2) double_window<T, largest>(first, n, columns + kx - 2 * n + 1);
      extreme_of_taps<T, largest, true>(shifts, nullptr, count, columns, target,
                                        tile_row(image, planes, tile, y + ry + 1));
    }
  });
}

// The pixels of a window of kh x kw, with what is added to them.
template <class T, bool largest>
class Window {
 public:
  Window(const T* heights, int64_t kh, int64_t kw, int64_t row, int64_t column, T absent) {
    // What the window leaves out cannot win against a pixel that is there whatever the border: the origin.
    const bool anchored = heights[row * kw + column] != -absent;
    for (int64_t i = 0; i < kh; ++i)
      for (int64_t j = 0; j < kw; ++j) {
        const T h = heights[i * kw + j];
        if (anchored && h == -absent) continue;
        taps_.push_back({i, j, largest ? h : -h});
        flat_ = flat_ && h == 0;
      }
  }

  int64_t count() const { return static_cast<int64_t>(taps_.size()); }

  // Row y of n pixels; `sources` has room for count() pointers.
  void combine(const PaddedRows<T>& rows, int64_t y, int64_t n, const T** sources, T* out) const {
    const T* const next = rows.advance(y, out);
    for (int64_t t = 0; t < count(); ++t) sources[t] = rows.at(y, taps_[t].row, taps_[t].column);
    (flat_ ? extreme_of_taps<T, largest, true> : extreme_of_taps<T, largest, false>)(sources, taps_.data(),
                                                                                     count(), n, out, next);
  }

 private:
  bool flat_ = true;
  std::vector<Tap<T>> taps_;
};

// high[k] -= low[k]
template <class T>
void subtract(T* high, const T* low, int64_t n) {
  for_lanes<T>(n, [=](auto d, auto, int64_t k) {
    hn::StoreU(hn::Sub(hn::LoadU(d, high + k), hn::LoadU(d, low + k)), d, high + k);
  });
}

template <class V>
HWY_INLINE V median(V a, V b, V c) {
  return larger(smaller(a, b), smaller(larger(a, b), c));
}

template <class T>
void sort_columns(const T* above, const T* here, const T* below, int64_t n, T* low, T* middle, T* high,
                  const T* next) {
  for_lanes_fetching<T>(n, next, [=](auto d, auto, int64_t k) {
    const auto a = hn::LoadU(d, above + k), b = hn::LoadU(d, here + k), c = hn::LoadU(d, below + k);
    const auto small = smaller(a, b), large = larger(a, b);
    hn::StoreU(smaller(small, c), d, low + k);
    hn::StoreU(larger(large, c), d, high + k);
    hn::StoreU(larger(small, smaller(large, c)), d, middle + k);
  });
}

// The median of nine is that of the largest of the columns' smallest, the median of their middle and the
// smallest of their largest.
template <class T>
void medians_along(const T* low, const T* middle, const T* high, int64_t n, T* out, const T* next) {
  for_lanes_fetching<T>(n, next, [=](auto d, auto, int64_t k) {
    const auto at = [=](const T* values, int64_t shift) { return hn::LoadU(d, values + k + shift); };
    const auto lowest = larger(larger(at(low, -1), at(low, 0)), at(low, 1)),
               highest = smaller(smaller(at(high, -1), at(high, 0)), at(high, 1));
    hn::StoreU(median(lowest, median(at(middle, -1), at(middle, 0), at(middle, 1)), highest), d, out + k);
  });
}

}  // namespace

template <class T>
void minmax_filter(const T* x, Planes planes, int64_t ky, int64_t kx, Border border, T value, bool largest,
                   T* out) {
  (largest ? rectangle<T, true> : rectangle<T, false>)(x, planes, ky, kx, border, value, out);
}

template <class T>
void morphology(const T* x, Planes planes, const T* heights, int64_t kh, int64_t kw, int64_t row,
                int64_t column, Border border, T value, T absent, bool largest, T* out) {
  const auto combine = [&](const auto& window) {
    std::vector<const T*> all_sources(static_cast<size_t>(window.count() * omp_get_max_threads()));
    for_tiles<T>(planes, kh + 2, kh, kw, border, [&](const Tile& tile, T* ring, int64_t length) {
      const int64_t plane = tile.plane * planes.height * planes.width;
      const T** const sources = all_sources.data() + window.count() * omp_get_thread_num();
      const PaddedRows<T> rows(x + plane, planes, tile, border, value, kh, kw, row, column, ring, length);
      for (int64_t y = tile.top; y < tile.bottom; ++y)
        window.combine(rows, y, tile.right - tile.left, sources, tile_row(out + plane, planes, tile, y));
    });
  };
  if (largest)
    combine(Window<T, true>(heights, kh, kw, row, column, absent));
  else
    combine(Window<T, false>(heights, kh, kw, row, column, absent));
}

template <class T>
void morphology_gradient(const T* x, Planes planes, const T* dilation_heights, int64_t kh, int64_t kw,
                         const T* erosion_heights, int64_t row, int64_t column, Border border,
                         T dilation_value, T erosion_value, T absent, T* out) {
  const Window<T, true> high(dilation_heights, kh, kw, row, column, absent);
  const Window<T, false> low(erosion_heights, kh, kw, row, column, absent);
  const int64_t count = std::max(high.count(), low.count());
  std::vector<const T*> all_sources(static_cast<size_t>(count * omp_get_max_threads()));
  for_tiles<T>(planes, 2 * kh + 3, 2 * kh + 1, kw, border, [&](const Tile& tile, T* scratch, int64_t length) {
    const int64_t plane = tile.plane * planes.height * planes.width, columns = tile.right - tile.left;
    const T** const sources = all_sources.data() + count * omp_get_thread_num();
    T *const low_ring = scratch + kh * length, *const line = low_ring + kh * length;
    const PaddedRows<T> high_rows(x + plane, planes, tile, border, dilation_value, kh, kw, row, column,
                                  scratch, length);
    const PaddedRows<T> low_rows(x + plane, planes, tile, border, erosion_value, kh, kw, row, column,
                                 low_ring, length);
    for (int64_t y = tile.top; y < tile.bottom; ++y) {
      T* const target = tile_row(out + plane, planes, tile, y);
      high.combine(high_rows, y, columns, sources, target);
      low.combine(low_rows, y, columns, sources, line);
      subtract(target, line, columns);
    }
  });
}

// A. Paeth, Median finding on a 3 x 3 grid, Graphics Gems, 1990; each column of three is sorted once, into
// three buffers.
template <class T>
void median3x3(const T* x, Planes planes, Border border, T* out) {
  const int64_t height = planes.height, width = planes.width;
  const std::vector<T> zeros(static_cast<size_t>(width));
  constexpr int64_t kLead = whole_lines<T>(1);
  for_tiles<T>(planes, 3 + 3 + 1, 3, kLead + 1, border, [&](const Tile& tile, T* scratch, int64_t length) {
    const T* const image = x + tile.plane * height * width;
    const Span span(tile, width, 1, 1);
    T *const low = scratch + kLead, *const middle = low + length, *const high = middle + length;
    const int64_t start = span.first - tile.left;
    for (int64_t y = tile.top; y < tile.bottom; ++y) {
      const auto row = [&](int64_t i) {
        const int64_t source = inside(i, height, border);
        return source < 0 ? zeros.data() : image + source * width + span.first;
      };
      T* const target = tile_row(out + tile.plane * height * width, planes, tile, y);
      sort_columns(row(y - 1), row(y), row(y + 1), span.count(), low + start, middle + start, high + start,
                   target);
      for (T* const values : {low, middle, high}) extend(values, tile, width, 1, 1, border, T(0));
      medians_along(low, middle, high, tile.right - tile.left, target, tile_row(image, planes, tile, y + 2));
    }
  });
}

CHIASM_INSTANTIATE(minmax_filter)
CHIASM_INSTANTIATE(morphology)
CHIASM_INSTANTIATE(morphology_gradient)
CHIASM_INSTANTIATE(median3x3)

}  // namespace chiasm::kernels
