// Reads images of integers at runs of positions, in planes and in frames.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "places_bytes.h"

namespace chiasm::kernels::bytes {

constexpr int64_t kRows = 32;

// The values of pixels outside: those of all channels, in turn, or one for all of them.
template <class Pixel>
struct Fill {
  const Pixel* values;
  int64_t count;
};

// The values of pixels outside for images whose pixels have `step` values.
template <class Pixel>
class Outside {
 public:
  Outside(Fill<Pixel> fill, int64_t step)
      : each_(step), values_(static_cast<size_t>(std::lcm(fill.count, step))) {
    for (size_t i = 0; i < values_.size(); ++i)
      values_[i] = fill.values[static_cast<int64_t>(i) % fill.count];
  }
  const Pixel* of(int64_t image) const {
    return values_.data() + image * each_ % static_cast<int64_t>(values_.size());
  }

 private:
  int64_t each_;
  std::vector<Pixel> values_;
};

// A run of n pixels from column `left` on, of row `row`, of an image that is moved by whole pixels.
template <class Pixel>
void copy_run(const Pixel* image, const Source& s, int64_t row, int64_t left, int64_t n, const Pixel* fill,
              Pixel* out) {
  const bool inside = row >= 0 && row < s.height;
  const int64_t first = inside ? std::clamp<int64_t>(-left, 0, n) : n,
                last = inside ? std::clamp<int64_t>(s.width - left, first, n) : n;
  const auto fill_up = [=](int64_t from, int64_t to) {
    for (int64_t i = from; i < to; ++i) std::copy_n(fill, s.step, out + i * s.step);
  };
  fill_up(0, first);
  if (last > first)
    std::memcpy(out + first * s.step, image + (row * s.width + left + first) * s.step,
                sizeof(Pixel) * static_cast<size_t>((last - first) * s.step));
  fill_up(last, n);
}

// Reads `each` images at positions(item, row, column, n, x, y), for each item.
template <class Taps, int kStep, class Pixel, class Positions>
void read_by(const Pixel* images, int64_t items, int64_t each, const Source& source, int64_t out_height,
             int64_t out_width, const Outside<Pixel>& outside, Pixel* out, const Positions& positions) {
  const int64_t blocks_y = (out_height + kRows - 1) / kRows, blocks_x = (out_width + kRun - 1) / kRun,
                size = source.height * source.row();
#pragma omp parallel for
  for (int64_t block = 0; block < items * blocks_y * blocks_x; ++block) {
    const int64_t left = block % blocks_x * kRun, top = block / blocks_x % blocks_y * kRows,
                  item = block / blocks_x / blocks_y;
    const int64_t n = std::min(kRun, out_width - left), bottom = std::min(top + kRows, out_height);
    const Pixel* const first = images + item * each * size;
    const auto run_of = [&](int64_t image, int64_t row) {
      return out + ((image * out_height + row) * out_width + left) * source.step;
    };
    if (const auto moved = positions.whole_shift(item); moved && source.padding == Padding::kZeros) {
      for (int64_t k = item * each; k < (item + 1) * each; ++k)
        for (int64_t row = top; row < bottom; ++row)
          copy_run(images + k * size, source, row + moved->second, left + moved->first, n, outside.of(k),
                   run_of(k, row));
      continue;
    }
    const int64_t ahead = Taps::ahead(source);
    Taps rows[2];
    const auto find = [&](int64_t row) {
      double x[kRun], y[kRun];
      positions(item, row, left, n, x, y);
      rows[row % 2].find(x, y, n, source);
    };
    find(top);
    for (int64_t row = top; row < bottom; ++row) {
      if (row + 1 < bottom) {
        // Prefetch one row ahead, because hardware prefetchers miss this pattern.
        find(row + 1);
        for (int64_t i = 0; i < n; i += 8) hwy::Prefetch(first + rows[(row + 1) % 2].index[i] + ahead);
      }
      for (int64_t k = item * each; k < (item + 1) * each; ++k)
        rows[row % 2].template read<kStep>(images + k * size, source, n, outside.of(k), run_of(k, row));
    }
  }
}

// Reads n images, which share `items` sets of positions.
template <class Taps, class Pixel, class Positions>
void read_with(const Pixel* images, int64_t n, int64_t items, Source source, int64_t out_height,
               int64_t out_width, Fill<Pixel> fill, Pixel* out, const Positions& positions) {
  const Outside<Pixel> outside(fill, source.step);
  source.wide = Taps::loaded(source.step);
  const auto by = [&](auto step) {
    read_by<Taps, decltype(step)::value>(images, items, n / items, source, out_height, out_width, outside,
                                         out, positions);
  };
  switch (source.step) {
    case 1: return by(std::integral_constant<int, 1>());
    case 3: return by(std::integral_constant<int, 3>());
    case 4: return by(std::integral_constant<int, 4>());
    default: return by(std::integral_constant<int, 0>());
  }
}

// The positions x and y (items, height, width).
template <class T>
struct Given {
  const T *x, *y;
  int64_t height, width;

  std::optional<std::pair<int64_t, int64_t>> whole_shift(int64_t) const { return std::nullopt; }

  void operator()(int64_t item, int64_t row, int64_t column, int64_t n, double* to_x, double* to_y) const {
    const int64_t start = (item * height + row) * width + column;
    std::copy_n(x + start, n, to_x);
    std::copy_n(y + start, n, to_y);
  }
};

// The positions to which matrices (items, 3, 3) map the pixels of the output.
struct Mapped {
  const double* matrix;

  // By how many columns and rows a matrix moves pixels, if it only moves them, by whole numbers.
  std::optional<std::pair<int64_t, int64_t>> whole_shift(int64_t item) const {
    const double* const m = matrix + 9 * item;
    const auto is_whole = [](double x) { return std::abs(x) < kFurthest && std::floor(x) == x; };
    const bool moves = m[0] == 1 && m[1] == 0 && m[3] == 0 && m[4] == 1 && m[6] == 0 && m[7] == 0 &&
                       m[8] == 1 && is_whole(m[2]) && is_whole(m[5]);
    if (!moves) return std::nullopt;
    return std::pair(static_cast<int64_t>(m[2]), static_cast<int64_t>(m[5]));
  }

  // In the same order as the definition, so that positions are equal.
  void operator()(int64_t item, int64_t row, int64_t column, int64_t count, double* x, double* y) const {
    const double *const m = matrix + 9 * item, v = static_cast<double>(row);
    const double a = m[0], b = m[1] * v, c = m[2], d = m[3], e = m[4] * v, f = m[5], g = m[6], h = m[7] * v,
                 k = m[8];
    const auto first = static_cast<int32_t>(column), n = static_cast<int32_t>(count);
    for (int32_t i = 0; i < n; ++i) {
      x[i] = a * (first + i) + b + c;
      y[i] = d * (first + i) + e + f;
    }
    if (g == 0 && m[7] == 0 && k == 1) return;
    for (int32_t i = 0; i < n; ++i) {
      const double depth = g * (first + i) + h + k;
      const double divisor = std::abs(depth) > 1e-8 ? depth : 1e-8;
      x[i] /= divisor;
      y[i] /= divisor;
    }
  }
};

}  // namespace chiasm::kernels::bytes
