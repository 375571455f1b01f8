// Reads images at positions: for a run of positions it finds the pixels and weights, which all channels
// share, and then reads each channel.
#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "bicubic.h"
#include "bilinear.h"
#include "declared/remap.h"

namespace chiasm::kernels {
namespace {

constexpr int64_t kRows = 32;

// For an image that is one row or column of `size` pixels.
template <class T>
void along_line(const T* line, const T* x, int64_t size, int64_t n, T* out) {
  for (int64_t i = 0; i < n; ++i) {
    const auto left = static_cast<int64_t>(x[i]);
    const T fraction = x[i] - static_cast<T>(left);
    out[i] = line[left] * (1 - fraction) + line[std::min(left + 1, size - 1)] * fraction;
  }
}

// The nearest pixels, half to even, and their weights: 1, or 0 outside.
template <class T>
void nearest_taps(const T* x, const T* y, int64_t n, int64_t height, int64_t width, int64_t stride,
                  Neighbours<T>& taps) {
  const Lanes<T> d;
  const auto all = [=](auto value) { return hn::Set(d, static_cast<T>(value)); };
  const auto right = all(width - 1), bottom = all(height - 1), zero = all(0);
  // limited before the conversion to an integer; NaN becomes 0
  const auto limited = [=](auto x, auto last) {
    return smaller(hn::IfThenElseZero(hn::Gt(x, zero), x), last);
  };
  const Integers<Lanes<T>> whole;
  const auto step = hn::Set(whole, static_cast<int32_t>(stride));
  for (int64_t i = 0; i < n; i += kLanes<T>) {
    const auto column = hn::Round(hn::LoadU(d, x + i)), row = hn::Round(hn::LoadU(d, y + i)),
               c = limited(column, right), r = limited(row, bottom);
    hn::StoreU(hn::Add(hn::Mul(truncated(d, r), step), truncated(d, c)), whole, taps.index + i);
    hn::StoreU(hn::IfThenElseZero(hn::And(hn::Eq(c, column), hn::Eq(r, row)), all(1)), d, taps.upper + i);
  }
}

// The pixels at indices, by one load if they lie in one vector.
template <class T>
HWY_INLINE hn::Vec<Lanes<T>> pixels(const T* plane, const int32_t* index, int64_t size) {
  const Lanes<T> d;
  if constexpr (sizeof(T) == sizeof(float)) {
    const auto from = from_first(index);
    if (in_one_vector(from) && *index + kLanes<T> <= size)
      return hn::TableLookupLanes(hn::LoadU(d, plane + *index), hn::IndicesFromVec(d, from));
  }
  return gathered(d, plane, index);
}

template <class T>
void nearest(const T* plane, int64_t size, const Neighbours<T>& taps, int64_t n, T* out) {
  const Lanes<T> d;
  int64_t i = 0;
  for (; i + kLanes<T> <= n; i += kLanes<T>)
    hn::StoreU(hn::Mul(pixels(plane, taps.index + i, size), hn::LoadU(d, taps.upper + i)), d, out + i);
  for (; i < n; ++i) out[i] = plane[taps.index[i]] * taps.upper[i];
}

// Prefetches the source pixels of the next output row: hardware prefetchers miss this pattern, which crosses
// the rows of an image of some megabytes.
template <class T>
void prefetch(const T* plane, const int32_t* index, int64_t n) {
  for (int64_t i = 0; i < n; i += 8) hwy::Prefetch(plane + index[i]);
}

// The planes that are read, and their padding.
struct Source {
  int64_t height, width, stride, size;
  Padding padding;
  bool align_corners, filled;  // whether pixels outside may be other than 0
};

// How a run of positions is read: `find` finds the pixels, `read` reads them from any plane. The prefetch is
// for the pixels `below` after `index`. If the source is filled, `rest` has what the weights lack to 1.
template <class T>
struct Bilinear : Neighbours<T> {
  alignas(64) T rest[kRun];

  void find(T* x, T* y, int64_t n, const Source& s) {
    place(x, n, s.width, s.padding, s.align_corners);
    place(y, n, s.height, s.padding, s.align_corners);
    bilinear_taps(x, y, n, s.height, s.width, s.stride, *this, s.filled ? rest : nullptr);
  }
  int64_t below(const Source& s) const { return s.stride; }
  void read(const T* plane, const Source& s, int64_t n, T* out) const {
    bilinear(plane, s.stride, *this, n, out);
  }
};

template <class T>
struct Nearest : Neighbours<T> {
  alignas(64) T rest[kRun];

  void find(T* x, T* y, int64_t n, const Source& s) {
    place(x, n, s.width, s.padding, s.align_corners);
    place(y, n, s.height, s.padding, s.align_corners);
    nearest_taps(x, y, n, s.height, s.width, s.stride, *this);
    for (int64_t i = 0; s.filled && i < n; ++i) rest[i] = 1 - this->upper[i];
  }
  int64_t below(const Source&) const { return 0; }
  void read(const T* plane, const Source& s, int64_t n, T* out) const {
    nearest(plane, s.size, *this, n, out);
  }
};

template <class T>
struct Bicubic : CubicTaps<T> {
  alignas(64) T rest[kRun];

  void find(T* x, T* y, int64_t n, const Source& s) {
    cubic_taps(x, y, n, s.height, s.width, s.stride, s.padding, s.align_corners, *this);
    for (int64_t i = 0; s.filled && i < n; ++i) {
      T sum = 0;
      for (const auto& down : this->down)
        for (const auto& across : this->across) sum += down[i] * across[i];
      rest[i] = 1 - sum;
    }
  }
  int64_t below(const Source&) const { return 0; }
  void read(const T* plane, const Source& s, int64_t n, T* out) const {
    bicubic(plane, s.stride, *this, n, out);
  }
};

// What pixels outside are, one number for each channel, or one for all.
template <class T>
struct Fill {
  const T* values;
  int64_t count;

  bool is_zero() const {
    return std::all_of(values, values + count, [](T value) { return value == 0; });
  }
  T of(int64_t channel) const { return values[channel % count]; }
};

// Reads the images at positions(image, row, column, n, x, y).
template <class Taps, class T, class Positions>
void sample_by(const T* source, Images images, int64_t out_height, int64_t out_width, Padding padding,
               bool align_corners, Fill<T> fill, T* out, const Positions& positions) {
  const int64_t height = images.height, width = images.width, planes = images.count * images.channels;
  const bool filled = padding == Padding::kZeros && !fill.is_zero();
  Source from{height, width, width, height * width, padding, align_corners, filled};
  std::vector<T> widened;
  if (height < 2 || width < 2) {  // without a second row or column, load one that has weight 0
    from.stride = width + 1;
    from.size = (height + 1) * from.stride;
    widened.resize(static_cast<size_t>(planes * from.size));
    for (int64_t p = 0; p < planes; ++p)
      for (int64_t y = 0; y < height; ++y)
        std::copy_n(source + (p * height + y) * width, width,
                    widened.data() + p * from.size + y * from.stride);
    source = widened.data();
  }
  const int64_t blocks_y = (out_height + kRows - 1) / kRows, blocks_x = (out_width + kRun - 1) / kRun;
#pragma omp parallel for
  for (int64_t block = 0; block < images.count * blocks_y * blocks_x; ++block) {
    const int64_t left = block % blocks_x * kRun, top = block / blocks_x % blocks_y * kRows,
                  image = block / blocks_x / blocks_y;
    const int64_t n = std::min(kRun, out_width - left);
    const int64_t bottom = std::min(top + kRows, out_height);
    Taps rows[2];
    const auto find = [&](int64_t row) {
      T x[kRun], y[kRun];
      positions(image, row, left, n, x, y);
      rows[row % 2].find(x, y, n, from);
    };
    find(top);
    for (int64_t row = top; row < bottom; ++row) {
      if (row + 1 < bottom) {
        find(row + 1);
        const Taps& next = rows[(row + 1) % 2];
        for (int64_t c = 0; c < images.channels; ++c)
          prefetch(source + (image * images.channels + c) * from.size + next.below(from), next.index, n);
      }
      for (int64_t c = 0; c < images.channels; ++c) {
        const int64_t plane = image * images.channels + c;
        T* const made = out + (plane * out_height + row) * out_width + left;
        rows[row % 2].read(source + plane * from.size, from, n, made);
        if (!from.filled) continue;
        const T value = fill.of(c), *const rest = rows[row % 2].rest;
        for (int64_t i = 0; i < n; ++i) made[i] += rest[i] * value;
      }
    }
  }
}

template <class T, class Positions>
void sample_at(const T* source, Images images, int64_t out_height, int64_t out_width, Interpolation mode,
               Padding padding, bool align_corners, Fill<T> fill, T* out, const Positions& positions) {
  const auto by = [&](auto taps) {
    sample_by<typename decltype(taps)::type>(source, images, out_height, out_width, padding, align_corners,
                                             fill, out, positions);
  };
  switch (mode) {
    case Interpolation::kNearest: return by(std::type_identity<Nearest<T>>());
    case Interpolation::kBilinear: return by(std::type_identity<Bilinear<T>>());
    case Interpolation::kBicubic: return by(std::type_identity<Bicubic<T>>());
  }
}

}  // namespace

template <class T>
void remap(const T* image, Images images, const T* x, int64_t out_height, int64_t out_width, const T* y,
           Interpolation mode, Padding padding, bool align_corners, const T* fill, int64_t fills, T* out) {
  sample_at(image, images, out_height, out_width, mode, padding, align_corners, {fill, fills}, out,
            [&](int64_t item, int64_t row, int64_t column, int64_t n, T* to_x, T* to_y) {
              const int64_t start = (item * out_height + row) * out_width + column;
              std::copy_n(x + start, n, to_x);
              std::copy_n(y + start, n, to_y);
            });
}

template <class T>
void warp_perspective(const T* image, Images images, const T* matrix, int64_t out_height, int64_t out_width,
                      Interpolation mode, Padding padding, bool align_corners, const T* fill, int64_t fills,
                      T* out) {
  sample_at(image, images, out_height, out_width, mode, padding, align_corners, {fill, fills}, out,
            [&](int64_t item, int64_t row, int64_t column, int64_t n, T* x, T* y) {
              const T* const m = matrix + 9 * item;
              const Lanes<T> d;
              const auto v = hn::Set(d, static_cast<T>(row)), least = hn::Set(d, T(1e-8));
              const auto product = [=](const T* of_row, auto u) {
                const auto sum =
                    hn::Add(hn::Mul(hn::Set(d, of_row[0]), u), hn::Mul(hn::Set(d, of_row[1]), v));
                return hn::Add(sum, hn::Set(d, of_row[2]));
              };
              const bool is_affine = m[6] == 0 && m[7] == 0 && m[8] == 1;
              for (int64_t i = 0; i < n; i += kLanes<T>) {
                const auto u = hn::Iota(d, static_cast<T>(column + i));
                auto to_x = product(m, u), to_y = product(m + 3, u);
                if (!is_affine) {
                  const auto depth = product(m + 6, u);
                  const auto divisor = hn::IfThenElse(hn::Gt(hn::Abs(depth), least), depth, least);
                  to_x = hn::Div(to_x, divisor);
                  to_y = hn::Div(to_y, divisor);
                }
                hn::StoreU(to_x, d, x + i);
                hn::StoreU(to_y, d, y + i);
              }
            });
}

template <class T>
void extract_patches(const T* pixels, int64_t rows, int64_t channels, int64_t length, const int64_t* start,
                     int64_t frames_per_row, const int64_t* height, const int64_t* width, const T* frames,
                     int64_t side, T* out) {
  const int64_t area = side * side;
  std::vector<T> across(static_cast<size_t>(area)), down(across);  // a patch's pixels in its frame
  for (int64_t y = 0; y < side; ++y)
    for (int64_t x = 0; x < side; ++x) {
      const auto k = static_cast<size_t>(y * side + x);
      across[k] = static_cast<T>(2 * x + 1) / static_cast<T>(side) - 1;
      down[k] = static_cast<T>(2 * y + 1) / static_cast<T>(side) - 1;
    }
#pragma omp parallel for
  for (int64_t i = 0; i < rows * frames_per_row; ++i) {
    const int64_t row = i / frames_per_row, frame = i % frames_per_row;
    const T* const m = frames + 6 * i;
    const T* const image = pixels + row * channels * length + start[i];
    Neighbours<T> taps;
    T x[kRun], y[kRun];
    // Otherwise no position in the patch is NaN, so only broken patches are checked pixel by pixel.
    const bool broken =
        !std::all_of(m, m + 6, [](T v) { return std::abs(v) < std::numeric_limits<T>::max() / 4; });
    // the frame of an empty slot: all pixels are the first one
    const bool point = m[0] == 0 && m[1] == 0 && m[3] == 0 && m[4] == 0;
    for (int64_t first = 0; first < (point ? 1 : area); first += kRun) {
      const int64_t n = point ? 1 : std::min(kRun, area - first);
      const T *const u = across.data() + first, *const v = down.data() + first;
      for (int64_t k = 0; k < n; ++k) {
        x[k] = m[0] * u[k] + m[1] * v[k] + m[2];
        y[k] = m[3] * u[k] + m[4] * v[k] + m[5];
      }
      bool undefined[kRun];  // set only if `broken`
      for (int64_t k = 0; broken && k < n; ++k)
        if ((undefined[k] = std::isnan(x[k]) || std::isnan(y[k]))) x[k] = y[k] = 0;
      place(x, n, width[i], Padding::kBorder, true);
      place(y, n, height[i], Padding::kBorder, true);
      const bool thin = height[i] < 2 || width[i] < 2;  // without a second row or column to load
      if (!thin) bilinear_taps(x, y, n, height[i], width[i], width[i], taps);
      for (int64_t c = 0; c < channels; ++c) {
        const T* const plane = image + c * length;
        T* const target = out + ((row * channels + c) * frames_per_row + frame) * area + first;
        if (thin)
          along_line(plane, width[i] > 1 ? x : y, std::max(height[i], width[i]), n, target);
        else
          bilinear(plane, width[i], taps, n, target);
        for (int64_t k = 0; broken && k < n; ++k)
          if (undefined[k]) target[k] = std::numeric_limits<T>::quiet_NaN();
        if (point) std::fill_n(target + 1, area - 1, *target);
      }
    }
  }
}

CHIASM_INSTANTIATE(remap)
CHIASM_INSTANTIATE(warp_perspective)
CHIASM_INSTANTIATE(extract_patches)

}  // namespace chiasm::kernels
