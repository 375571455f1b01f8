// Convolutions of images (B, H, W, C) by the indirect convolution algorithm (M. Dukhan, arXiv:1907.02129,
// 2019): an array of pointers to the pixels under each window replaces the im2col matrix, and a pixel of
// zeros replaces padding.
#include <omp.h>

#include <algorithm>
#include <vector>

#include "declared/convolution.h"
#include "lanes.h"
#include "products.h"

namespace chiasm::kernels {
namespace {

template <class D>
HWY_INLINE hn::Vec<D> limited(D d, hn::Vec<D> value, hn::TFromD<D> low, hn::TFromD<D> high) {
  return smaller(hn::Set(d, high), larger(hn::Set(d, low), value));  // NaN stays NaN
}

// A task is kTiles tiles of pixels times kPanels panels: small enough for L2, large enough that the time for
// computing the pointers is negligible.
constexpr int64_t kTiles = 16, kPanels = 8;
constexpr int64_t kMostPointers = int64_t{1} << 17;

}  // namespace

template <class T>
void packed_convolution(const T* x, int64_t b, int64_t h, int64_t w, int64_t c, const T* weight, int64_t p,
                        int64_t kh, int64_t kw, int64_t g, const T* bias, int64_t n, int64_t stride_y,
                        int64_t stride_x, int64_t top, int64_t left, int64_t dilation_y, int64_t dilation_x,
                        int64_t height, int64_t width, T low, T high, T* out) {
  constexpr int64_t rows = Block<T>::kRows;
  const int64_t taps = kh * kw, pixels = b * height * width, groups = c / g, outputs = n / groups;
  const int64_t tiles = std::clamp<int64_t>(kMostPointers / (taps * rows), 1, kTiles);
  const int64_t blocks = (pixels + tiles * rows - 1) / (tiles * rows), chunks = (p + kPanels - 1) / kPanels;
  const std::vector<T> zeros(static_cast<size_t>(c));
  const int64_t pointers = tiles * taps * rows;
  std::vector<const T*> all_pieces(static_cast<size_t>(pointers * omp_get_max_threads()));

#pragma omp parallel for
  for (int64_t task = 0; task < blocks * chunks; ++task) {
    const int64_t first = task / chunks * tiles * rows, end = std::min(first + tiles * rows, pixels);
    const T** const pieces = all_pieces.data() + pointers * omp_get_thread_num();
    int64_t column = first % width, line = first / width;  // divided once, as divisions are slow
    int64_t y = line % height * stride_y - top;
    const T* image = x + line / height * h * w * c;
    for (int64_t i = 0; i < tiles * rows; ++i) {
      const int64_t x0 = column * stride_x - left;
      const T** to = pieces + i / rows * taps * rows + i % rows;
      for (int64_t ky = 0; ky < kh; ++ky)
        for (int64_t kx = 0; kx < kw; ++kx, to += rows) {
          const int64_t from_y = y + ky * dilation_y, from_x = x0 + kx * dilation_x;
          const bool is_inside = from_y >= 0 && from_y < h && from_x >= 0 && from_x < w;
          *to = is_inside ? image + (from_y * w + from_x) * c : zeros.data();
        }
      if (first + i + 1 >= end) continue;  // the rest of the last tile reads the last pixel again
      if (++column < width) continue;
      column = 0;
      if (++line % height == 0) image += h * w * c;
      y = line % height * stride_y - top;
    }
    const int64_t panels = p / groups, size = taps * g * kPanel;  // panels of a group, size of a panel
    const auto multiply_pixels = [&](auto together, int64_t panel) {
      const int64_t group = panel / panels, before = panel % panels * kPanel;
      const int64_t there = std::min(together * kPanel, outputs - before), output = group * outputs + before;
      T start[together * kPanel] = {};
      std::copy_n(bias + output, there, start);
      for (int64_t pixel = first; pixel < end; pixel += rows) {
        T* const to = out + pixel * n + output;
        const int64_t last = std::min(rows, end - pixel);
        multiply<together>(pieces + (pixel - first) * taps, taps, g, group * g, weight + panel * size, size,
                           start, [=](int64_t row, int64_t k, auto values) {
                             if (row < last)
                               store_first<T>(limited(Lanes<T>(), values, low, high), to + row * n + k,
                                              there - k);
                           });
      }
    };
    int64_t panel = task % chunks * kPanels;
    for (const int64_t last = std::min(panel + kPanels, p); panel < last;) {
      const int64_t next = std::min(last, (panel / panels + 1) * panels);  // the end of the group
      multiply_panels<T>(panel, next, multiply_pixels);
      panel = next;
    }
  }
}

template <class T>
void depthwise_convolution(const T* x, int64_t b, int64_t h, int64_t w, int64_t c, const T* weight,
                           int64_t kh, int64_t kw, const T* bias, int64_t stride_y, int64_t stride_x,
                           int64_t top, int64_t left, int64_t dilation_y, int64_t dilation_x, int64_t height,
                           int64_t width, T low, T high, T* out) {
  // Range of the taps of a window at `from` that lie within 0..size.
  const auto taps_inside = [](int64_t from, int64_t dilation, int64_t taps, int64_t size) {
    if (from >= 0 && from + (taps - 1) * dilation < size) return std::pair(int64_t{0}, taps);
    const int64_t first = from < 0 ? (-from + dilation - 1) / dilation : 0;
    const int64_t end = from < size ? std::min(taps, (size - 1 - from) / dilation + 1) : 0;
    return std::pair(std::min(first, taps), end);
  };
  constexpr int64_t kColumns = 4;  // results that share the loads of weights
#pragma omp parallel for
  for (int64_t line = 0; line < b * height; ++line) {
    const int64_t y = line % height * stride_y - top;
    const auto rows = taps_inside(y, dilation_y, kh, h);
    const int64_t above = line / height * h + y;
    // `count` results from a column on, of the taps first..end of each row of the window
    const auto compute = [&](auto count, int64_t column, int64_t first, int64_t end) {
      const int64_t from = column * stride_x - left;
      T* const to = out + (line * width + column) * c;
      for_lanes<T, count == 1 ? 4 : 2>(c, [=](auto d, auto vectors, int64_t k) {
        using V = hn::Vec<decltype(d)>;
        constexpr auto lanes = static_cast<int64_t>(hn::MaxLanes(d));
        V sums[count][vectors];
        for (auto& sum : sums)
          for (int64_t v = 0; v < vectors; ++v) sum[v] = hn::LoadU(d, bias + k + v * lanes);
        for (int64_t ky = rows.first; ky < rows.second; ++ky)
          for (int64_t kx = first; kx < end; ++kx) {
            const T* const values = x + ((above + ky * dilation_y) * w + from + kx * dilation_x) * c + k;
            const T* const factors = weight + (ky * kw + kx) * c + k;
            for (int64_t v = 0; v < vectors; ++v) {
              const V factor = hn::LoadU(d, factors + v * lanes);
              for (int64_t i = 0; i < count; ++i)
                sums[i][v] =
                    hn::MulAdd(hn::LoadU(d, values + i * stride_x * c + v * lanes), factor, sums[i][v]);
            }
          }
        for (int64_t i = 0; i < count; ++i)
          for (int64_t v = 0; v < vectors; ++v)
            hn::StoreU(limited(d, sums[i][v], low, high), d, to + i * c + k + v * lanes);
      });
    };
    for (int64_t column = 0; column < width;) {
      const int64_t from = column * stride_x - left, next = std::min(column + kColumns, width);
      if (column + kColumns == next && from >= 0 &&
          (next - 1) * stride_x - left + (kw - 1) * dilation_x < w) {
        compute(std::integral_constant<int64_t, kColumns>(), column, 0, kw);
        column = next;
      } else {
        const auto [first, end] = taps_inside(from, dilation_x, kw, w);
        compute(std::integral_constant<int64_t, 1>(), column++, first, end);
      }
    }
  }
}

CHIASM_INSTANTIATE(packed_convolution)
CHIASM_INSTANTIATE(depthwise_convolution)

}  // namespace chiasm::kernels
