// Images read at positions: for a run of positions the pixels and weights first, which all channels share,
// and then each channel.
#include <cmath>
#include <cstring>
#include <limits>

#include "rows.h"

namespace chiasm::kernels {
namespace {

constexpr int64_t kRun = 256, kRows = 32;

// What a run of positions reads. Neighbours in a row are loaded together: of each pixel's pair the weights
// lie side by side, of a vector of positions those of the even ones before those of the odd ones. Where the
// pairs of a vector of positions lie among a vector of pixels and one more in a row, which two loads have,
// the first pixels' weights come before the second ones'.
template <class T>
struct Neighbours {
  alignas(64) int32_t index[kRun];
  alignas(64) T upper[2 * kRun], lower[2 * kRun];
  bool near[kRun / kLanes<T>];
};

// Folds positions into the image, by mirroring at the corner pixels' centres or at the outer edges.
template <class T>
void reflect(T* x, int64_t n, int64_t size, bool align_corners) {
  const T low = align_corners ? T(0) : T(-0.5),
          span = static_cast<T>(align_corners ? std::max<int64_t>(size - 1, 1) : size),
          last = static_cast<T>(size - 1);
  for (int64_t i = 0; i < n; ++i) {
    const T t = std::abs(x[i] - low), turns = std::floor(t / span), rest = t - turns * span;
    const T folded = (turns - 2 * std::floor(turns * T(0.5)) > T(0.5) ? span - rest : rest) + low;
    x[i] = std::min(std::max(folded, T(0)), last);
  }
}

// Runs of positions have room for whole vectors: what stands behind their end is computed, too, and not used.

// Limits positions; NaN stays.
template <class T>
void limit(T* x, int64_t n, T low, T high) {
  const Lanes<T> d;
  for (int64_t i = 0; i < n; i += kLanes<T>)
    hn::StoreU(smaller(hn::Set(d, high), larger(hn::Set(d, low), hn::LoadU(d, x + i))), d, x + i);
}

template <class T>
void place(T* x, int64_t n, int64_t size, Padding padding, bool align_corners) {
  if (padding == Padding::kBorder) limit(x, n, T(0), static_cast<T>(size - 1));
  if (padding == Padding::kReflection) reflect(x, n, size, align_corners);
}

// Of each position the pair of pixels to read along an axis, as its first one, and their weights, 0 where
// they are outside.
template <class T>
void pair_up(const T* x, int64_t n, int64_t size, int32_t* first, T* weight0, T* weight1) {
  const Lanes<T> d;
  const auto all = [=](auto value) { return hn::Set(d, static_cast<T>(value)); };
  const auto zero = all(0), one = all(1), end = all(size - 1), last = all(std::max<int64_t>(size - 2, 0)),
             least = all(-2), greatest = all(size + 1);
  const auto put = [=](int64_t i, auto from, auto weight_of_first, auto weight_of_second) {
    hn::StoreU(truncated(d, from), Integers<Lanes<T>>(), first + i);
    hn::StoreU(weight_of_first, d, weight0 + i);
    hn::StoreU(weight_of_second, d, weight1 + i);
  };
  for (int64_t i = 0; i < n; i += kLanes<T>) {
    const auto given = hn::LoadU(d, x + i);
    if (size > 1 && hn::AllTrue(d, hn::And(hn::Ge(given, zero), hn::Le(given, end)))) {
      const auto from = smaller(hn::Floor(given), last), fraction = hn::Sub(given, from);
      put(i, from, hn::Sub(one, fraction), fraction);
      continue;
    }
    // one pixel outside is as empty as a thousand; not a number is, too
    const auto position = smaller(larger(given, least), greatest);
    const auto pixel = hn::Floor(position), fraction = hn::Sub(position, pixel),
               from = smaller(larger(pixel, zero), last);
    const auto near =
        hn::IfThenElseZero(hn::And(hn::Ge(pixel, zero), hn::Le(pixel, end)), hn::Sub(one, fraction));
    const auto far = hn::IfThenElseZero(hn::And(hn::Ge(pixel, hn::Neg(one)), hn::Lt(pixel, end)), fraction);
    // Before the first pixel the second of the two is the pair's first, and at the last pixel the first is
    // the pair's second.
    const auto same = hn::Eq(pixel, from);
    put(i, from, hn::Add(hn::IfThenElseZero(same, near), hn::IfThenElseZero(hn::Lt(pixel, from), far)),
        hn::Add(hn::IfThenElseZero(same, far), hn::IfThenElseZero(hn::Gt(pixel, from), near)));
  }
}

// Where a row is read forwards and not by larger steps than one, the pixels at a vector of indices lie in one
// vector: how far each is from the first.
using Indices = Integers<Lanes<float>>;

HWY_INLINE hn::Vec<Indices> from_first(const int32_t* index) {
  const Indices integers;
  return hn::Sub(hn::LoadU(integers, index), hn::Set(integers, *index));
}

HWY_INLINE bool in_one_vector(hn::Vec<Indices> from_first) {
  const Indices integers;
  return hn::AllTrue(
      integers, hn::Eq(hn::And(from_first, hn::Set(integers, ~(static_cast<int32_t>(kLanes<float>) - 1))),
                       hn::Zero(integers)));
}

template <class T>
void bilinear_taps(const T* x, const T* y, int64_t n, int64_t height, int64_t width, int64_t stride,
                   Neighbours<T>& taps) {
  const Lanes<T> d;
  constexpr int64_t lanes = kLanes<T>;
  int32_t column[kRun], row[kRun];
  T left[kRun], right[kRun], top[kRun], bottom[kRun];
  pair_up(x, n, width, column, left, right);
  pair_up(y, n, height, row, top, bottom);
  for (int64_t i = 0; i < n; ++i) taps.index[i] = row[i] * static_cast<int32_t>(stride) + column[i];
  // the last that has a vector of pixels and one more in its row and below
  const int64_t last = (height - 2) * stride + width - lanes - 1;
  for (int64_t i = 0; i < n; i += lanes) {
    const auto at = [=](const T* weights) { return hn::LoadU(d, weights + i); };
    const auto first = at(left), second = at(right), above = at(top), below = at(bottom);
    bool near = false;
    if constexpr (sizeof(T) == sizeof(float))
      near = i + lanes <= n && taps.index[i] <= last && in_one_vector(from_first(taps.index + i));
    taps.near[i / lanes] = near;
    T *const upper = taps.upper + 2 * i, *const lower = taps.lower + 2 * i;
    if (near) {
      hn::StoreU(hn::Mul(above, first), d, upper);
      hn::StoreU(hn::Mul(above, second), d, upper + lanes);
      hn::StoreU(hn::Mul(below, first), d, lower);
      hn::StoreU(hn::Mul(below, second), d, lower + lanes);
    } else {
      const auto even = hn::OddEven(hn::DupEven(second), first), odd = hn::OddEven(second, hn::DupOdd(first));
      hn::StoreU(hn::Mul(hn::DupEven(above), even), d, upper);
      hn::StoreU(hn::Mul(hn::DupOdd(above), odd), d, upper + lanes);
      hn::StoreU(hn::Mul(hn::DupEven(below), even), d, lower);
      hn::StoreU(hn::Mul(hn::DupOdd(below), odd), d, lower + lanes);
    }
  }
}

// The pairs of pixels at every second position.
template <class D, class T>
HWY_INLINE hn::Vec<D> pairs(D d, const T* p, const int32_t* index) {
  const hn::FixedTag<T, 16 / sizeof(T)> part;
  return combined<decltype(part)>(d, [=](int64_t i) {
    if constexpr (sizeof(T) == sizeof(double)) {
      return hn::LoadU(part, p + index[i]);
    } else {
      double first, second;  // of two pixels each, at any address
      std::memcpy(&first, p + index[i], sizeof first);
      std::memcpy(&second, p + index[i + 2], sizeof second);
      const hn::FixedTag<double, 2> two;
      return hn::BitCast(part, hn::OddEven(hn::Set(two, second), hn::Set(two, first)));
    }
  });
}

// Adds up the pairs, of which the even positions' are in one vector and the odd ones' in the other.
template <class D>
HWY_INLINE hn::Vec<D> sum_pairs(D d, hn::Vec<D> even, hn::Vec<D> odd) {
  return hn::Add(hn::OddEven(odd, even), hn::Reverse2(d, hn::OddEven(even, odd)));
}

template <class T>
void bilinear(const T* plane, int64_t stride, const Neighbours<T>& taps, int64_t n, T* out) {
  const Lanes<T> d;
  constexpr int64_t lanes = kLanes<T>;
  const T* const below = plane + stride;
  int64_t i = 0;
  for (; i + lanes <= n; i += lanes) {
    if constexpr (sizeof(T) == sizeof(float)) {
      if (taps.near[i / lanes]) {
        const auto from = hn::IndicesFromVec(d, from_first(taps.index + i));
        const T *const a = plane + taps.index[i], *const b = a + stride, *const upper = taps.upper + 2 * i,
                       *const lower = taps.lower + 2 * i;
        const auto product = [=](const T* pixels, const T* weights) {
          return hn::Mul(hn::TableLookupLanes(hn::LoadU(d, pixels), from), hn::LoadU(d, weights));
        };
        const auto first = hn::Add(product(a, upper), product(b, lower)),
                   second = hn::Add(product(a + 1, upper + lanes), product(b + 1, lower + lanes));
        hn::StoreU(hn::Add(first, second), d, out + i);
        continue;
      }
    }
    const auto weighed = [=, &taps](int64_t first, int64_t k) {
      const int32_t* const index = taps.index + first;
      return hn::Add(hn::Mul(pairs(d, plane, index), hn::LoadU(d, taps.upper + k)),
                     hn::Mul(pairs(d, below, index), hn::LoadU(d, taps.lower + k)));
    };
    hn::StoreU(sum_pairs(d, weighed(i, 2 * i), weighed(i + 1, 2 * i + lanes)), d, out + i);
  }
  for (; i < n; ++i) {
    const T *const a = plane + taps.index[i], *const b = below + taps.index[i];
    const int64_t k = 2 * (i / lanes * lanes) + i % 2 * lanes + i % lanes / 2 * 2;  // of the pair's weights
    out[i] =
        (a[0] * taps.upper[k] + b[0] * taps.lower[k]) + (a[1] * taps.upper[k + 1] + b[1] * taps.lower[k + 1]);
  }
}

// Of an image that is one row or column of `size` pixels.
template <class T>
void along_line(const T* line, const T* x, int64_t size, int64_t n, T* out) {
  for (int64_t i = 0; i < n; ++i) {
    const auto left = static_cast<int64_t>(x[i]);
    const T fraction = x[i] - static_cast<T>(left);
    out[i] = line[left] * (1 - fraction) + line[std::min(left + 1, size - 1)] * fraction;
  }
}

// To the nearest whole number, halves to the even one: by adding a number so large that no fraction is left.
// Unlike nearbyint it is vectorised.
inline float rounded(float x) { return (x + 12582912.0f) - 12582912.0f; }
inline double rounded(double x) { return (x + 6755399441055744.0) - 6755399441055744.0; }

// The nearest pixels, halves to the even one, and as weight 1, or 0 outside.
template <class T>
void nearest_taps(const T* x, const T* y, int64_t n, int64_t height, int64_t width, int64_t stride,
                  Neighbours<T>& taps) {
  const auto right = static_cast<T>(width - 1), bottom = static_cast<T>(height - 1);
  // as a number, for not every one is a pixel's; what is not a number becomes 0
  const auto limited = [](T x, T last) {
    const T above = x > 0 ? x : T(0);
    return above < last ? above : last;
  };
  for (int64_t i = 0; i < n; ++i) {
    const T column = rounded(x[i]), row = rounded(y[i]), c = limited(column, right), r = limited(row, bottom);
    taps.index[i] = static_cast<int32_t>(r) * static_cast<int32_t>(stride) + static_cast<int32_t>(c);
    taps.upper[i] = (c == column) & (r == row) ? T(1) : T(0);
  }
}

// The pixels at indices, by one load where they lie in one vector.
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

// Samples where positions(image, row, column, n, x, y) says.
template <class T, class Positions>
void sample_at(const T* source, Images images, int64_t out_height, int64_t out_width, Interpolation mode,
               Padding padding, bool align_corners, T* out, const Positions& positions) {
  const int64_t height = images.height, width = images.width, planes = images.count * images.channels;
  int64_t stride = width, plane_size = height * width;
  std::vector<T> widened;
  if (height < 2 || width < 2) {  // where there is no second row or column to load, one with no weight
    stride = width + 1;
    plane_size = (height + 1) * stride;
    widened.resize(static_cast<size_t>(planes * plane_size));
    for (int64_t p = 0; p < planes; ++p)
      for (int64_t y = 0; y < height; ++y)
        std::copy_n(source + (p * height + y) * width, width, widened.data() + p * plane_size + y * stride);
    source = widened.data();
  }
  const int64_t blocks_y = (out_height + kRows - 1) / kRows, blocks_x = (out_width + kRun - 1) / kRun;
#pragma omp parallel for
  for (int64_t block = 0; block < images.count * blocks_y * blocks_x; ++block) {
    const int64_t left = block % blocks_x * kRun, top = block / blocks_x % blocks_y * kRows,
                  image = block / blocks_x / blocks_y;
    const int64_t n = std::min(kRun, out_width - left);
    const int64_t bottom = std::min(top + kRows, out_height);
    Neighbours<T> rows[2];
    const auto find = [&](int64_t row) {
      T x[kRun], y[kRun];
      positions(image, row, left, n, x, y);
      place(x, n, width, padding, align_corners);
      place(y, n, height, padding, align_corners);
      if (mode == Interpolation::kBilinear)
        bilinear_taps(x, y, n, height, width, stride, rows[row % 2]);
      else
        nearest_taps(x, y, n, height, width, stride, rows[row % 2]);
    };
    find(top);
    for (int64_t row = top; row < bottom; ++row) {
      const Neighbours<T>& taps = rows[row % 2];
      if (row + 1 < bottom) {
        find(row + 1);
        const int32_t* const next = rows[(row + 1) % 2].index;
        const int64_t below = mode == Interpolation::kBilinear ? stride : 0;
        for (int64_t c = 0; c < images.channels; ++c)
          prefetch(source + (image * images.channels + c) * plane_size + below, next, n);
      }
      for (int64_t c = 0; c < images.channels; ++c) {
        const int64_t plane = image * images.channels + c;
        T* const target = out + (plane * out_height + row) * out_width + left;
        if (mode == Interpolation::kBilinear)
          bilinear(source + plane * plane_size, stride, taps, n, target);
        else
          nearest(source + plane * plane_size, plane_size, taps, n, target);
      }
    }
  }
}

}  // namespace

template <class T>
void remap(const T* image, Images images, const T* x, int64_t out_height, int64_t out_width, const T* y,
           Interpolation mode, Padding padding, bool align_corners, T* out) {
  sample_at(image, images, out_height, out_width, mode, padding, align_corners, out,
            [&](int64_t item, int64_t row, int64_t column, int64_t n, T* to_x, T* to_y) {
              const int64_t start = (item * out_height + row) * out_width + column;
              std::copy_n(x + start, n, to_x);
              std::copy_n(y + start, n, to_y);
            });
}

template <class T>
void warp_perspective(const T* image, Images images, const T* matrix, int64_t out_height, int64_t out_width,
                      Interpolation mode, Padding padding, bool align_corners, T* out) {
  sample_at(image, images, out_height, out_width, mode, padding, align_corners, out,
            [&](int64_t item, int64_t row, int64_t column, int64_t n, T* x, T* y) {
              const T *const m = matrix + 9 * item, v = static_cast<T>(row);
              for (int64_t i = 0; i < n; ++i) {
                const T u = static_cast<T>(column + i), depth = m[6] * u + m[7] * v + m[8];
                const T divisor = std::abs(depth) > T(1e-8) ? depth : T(1e-8);
                x[i] = (m[0] * u + m[1] * v + m[2]) / divisor;
                y[i] = (m[3] * u + m[4] * v + m[5]) / divisor;
              }
            });
}

template <class T>
void extract_patches(const T* pixels, int64_t rows, int64_t channels, int64_t length, const int64_t* start,
                     int64_t frames_per_row, const int64_t* height, const int64_t* width, const T* frames,
                     int64_t side, T* out) {
  const int64_t area = side * side;
  std::vector<T> across(static_cast<size_t>(area)), down(across);  // where a patch's pixels are in its frame
  for (int64_t k = 0; k < area; ++k) {
    across[static_cast<size_t>(k)] = static_cast<T>(2 * (k % side) + 1) / static_cast<T>(side) - 1;
    down[static_cast<size_t>(k)] = static_cast<T>(2 * (k / side) + 1) / static_cast<T>(side) - 1;
  }
#pragma omp parallel for
  for (int64_t i = 0; i < rows * frames_per_row; ++i) {
    const int64_t row = i / frames_per_row, frame = i % frames_per_row;
    const T* const m = frames + 6 * i;
    const T* const image = pixels + row * channels * length + start[i];
    Neighbours<T> taps;
    T x[kRun], y[kRun];
    // Else no sum of products of theirs with numbers from -1 to 1 is NaN, and all patches but broken ones are
    // read without looking.
    const bool broken =
        !std::all_of(m, m + 6, [](T v) { return std::abs(v) < std::numeric_limits<T>::max() / 4; });
    // an empty slot's frame: all pixels are the first
    const bool point = m[0] == 0 && m[1] == 0 && m[3] == 0 && m[4] == 0;
    for (int64_t first = 0; first < (point ? 1 : area); first += kRun) {
      const int64_t n = point ? 1 : std::min(kRun, area - first);
      const T *const u = across.data() + first, *const v = down.data() + first;
      for (int64_t k = 0; k < n; ++k) {
        x[k] = m[0] * u[k] + m[1] * v[k] + m[2];
        y[k] = m[3] * u[k] + m[4] * v[k] + m[5];
      }
      bool undefined[kRun];  // where `broken`
      for (int64_t k = 0; broken && k < n; ++k)
        if ((undefined[k] = std::isnan(x[k]) || std::isnan(y[k]))) x[k] = y[k] = 0;
      place(x, n, width[i], Padding::kBorder, true);
      place(y, n, height[i], Padding::kBorder, true);
      const bool thin = height[i] < 2 || width[i] < 2;  // there is no second row or column to load
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
