// Shapes painted over images, row by row.
#include <algorithm>

#include "declared/drawing.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// Paints columns first..end-1, as far as they are inside a row.
template <class T>
void paint(T* row, int64_t width, int64_t first, int64_t end, T color) {
  first = std::clamp<int64_t>(first, 0, width);
  end = std::clamp<int64_t>(end, first, width);
  std::fill(row + first, row + end, color);
}

}  // namespace

template <class T>
void draw_rectangles(const T* image, Images images, const int64_t* corners, int64_t count, const T* colors,
                     int64_t before, int64_t after, bool fill, T* out) {
  constexpr int64_t kFar = int64_t{1} << 40;
  const int64_t height = images.height, width = images.width, size = height * width;
#pragma omp parallel for
  for (int64_t plane = 0; plane < images.count * images.channels; ++plane) {
    T* const to = out + plane * size;
    std::copy_n(image + plane * size, size, to);
    for (int64_t i = 0; i < count; ++i) {
      int64_t c[4];
      for (int64_t k = 0; k < 4; ++k)
        c[k] = std::clamp(corners[(plane / images.channels * count + i) * 4 + k], -kFar, kFar);
      const auto [x1, y1, x2, y2] = c;
      if (x2 < x1 || y2 < y1) continue;
      const T color = colors[plane * count + i];
      // the inner rows and columns, first..end-1, which are not painted
      const int64_t left = x1 + after + 1, right = x2 - before, top = y1 + after + 1, bottom = y2 - before;
      const bool hollow = !fill && left < right;
      const int64_t outer = fill ? 0 : before, beyond = fill ? 0 : after;
      for (int64_t y = std::max<int64_t>(y1 - outer, 0); y <= std::min(y2 + beyond, height - 1); ++y) {
        T* const row = to + y * width;
        if (hollow && y >= top && y < bottom) {
          paint(row, width, x1 - outer, left, color);
          paint(row, width, right, x2 + beyond + 1, color);
        } else {
          paint(row, width, x1 - outer, x2 + beyond + 1, color);
        }
      }
    }
  }
}

template <class T>
void fill_spans(const T* image, Images images, const int64_t* first, int64_t spans, const int64_t* end,
                const T* colors, T* out) {
  const int64_t height = images.height, width = images.width;
#pragma omp parallel for
  for (int64_t i = 0; i < images.count * images.channels * height; ++i) {
    const int64_t plane = i / height;
    T* const row = out + i * width;
    std::copy_n(image + i * width, width, row);
    for (int64_t k = 0; k < spans; ++k) {
      const int64_t at = (plane / images.channels * spans + k) * height + i % height;
      paint(row, width, first[at], end[at], colors[plane]);
    }
  }
}

CHIASM_INSTANTIATE(draw_rectangles)
CHIASM_INSTANTIATE(fill_spans)

}  // namespace chiasm::kernels
