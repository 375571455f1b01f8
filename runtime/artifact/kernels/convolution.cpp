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
    for (int64_t i = 0; i < tiles * rows; ++i) {
      const int64_t pixel = std::min(first + i, end - 1), line = pixel / width;
      const int64_t y = line % height * stride_y - top, x0 = pixel % width * stride_x - left;
      const T* const image = x + line / height * h * w * c;
      const T** to = pieces + i / rows * taps * rows + i % rows;
      for (int64_t ky = 0; ky < kh; ++ky)
        for (int64_t kx = 0; kx < kw; ++kx, to += rows) {
          const int64_t from_y = y + ky * dilation_y, from_x = x0 + kx * dilation_x;
          const bool is_inside = from_y >= 0 && from_y < h && from_x >= 0 && from_x < w;
          *to = is_inside ? image + (from_y * w + from_x) * c : zeros.data();
        }
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
    const int64_t first = from < 0 ? (-from + dilation - 1) / dilation : 0;
    const int64_t end = from < size ? std::min(taps, (size - 1 - from) / dilation + 1) : 0;
    return std::pair(std::min(first, taps), end);
  };
#pragma omp parallel for
  for (int64_t line = 0; line < b * height; ++line) {
    const int64_t y = line % height * stride_y - top;
    const auto [first_y, end_y] = taps_inside(y, dilation_y, kh, h);
    for (int64_t column = 0; column < width; ++column) {
      const int64_t x0 = column * stride_x - left;
      const auto [first_x, end_x] = taps_inside(x0, dilation_x, kw, w);
      const T* const image = x + line / height * h * w * c;
      T* const to = out + (line * width + column) * c;
      // C++17 lambdas cannot capture structured bindings
      const int64_t tap_y = first_y, below = end_y, tap_x = first_x, right = end_x;
      for_lanes<T, 4>(c, [=](auto d, auto vectors, int64_t k) {
        using V = hn::Vec<decltype(d)>;
        constexpr auto lanes = static_cast<int64_t>(hn::MaxLanes(d));
        V sums[vectors];
        for (int64_t v = 0; v < vectors; ++v) sums[v] = hn::LoadU(d, bias + k + v * lanes);
        for (int64_t ky = tap_y; ky < below; ++ky)
          for (int64_t kx = tap_x; kx < right; ++kx) {
            const T* const values = image + ((y + ky * dilation_y) * w + x0 + kx * dilation_x) * c + k;
            const T* const factors = weight + (ky * kw + kx) * c + k;
            for (int64_t v = 0; v < vectors; ++v)
              sums[v] =
                  hn::MulAdd(hn::LoadU(d, values + v * lanes), hn::LoadU(d, factors + v * lanes), sums[v]);
          }
        for (int64_t v = 0; v < vectors; ++v)
          hn::StoreU(limited(d, sums[v], low, high), d, to + k + v * lanes);
      });
    }
  }
}

CHIASM_INSTANTIATE(packed_convolution)
CHIASM_INSTANTIATE(depthwise_convolution)

}  // namespace chiasm::kernels
