// Images read at positions: for a run of positions the pixels and weights first, which all channels share, and then each channel.
#include <cmath>
#include <cstring>
#include <limits>

#include "rows.h"

namespace chiasm::kernels {
namespace {

constexpr int64_t kRun = 256, kRows = 32;

// What a run of positions reads. Neighbours in a row are loaded together: of each pixel's pair the weights lie side by side. Where the pairs of a
// vector of positions lie among nine pixels in a row, which two loads have, the first ones' weights come before the second ones'.
template <class T>
struct Neighbours {
  alignas(64) int32_t index[kRun];
  alignas(64) T upper[2 * kRun], lower[2 * kRun];
  bool near[kRun / Vector<T>::kLanes];
};

// Folds positions into the image, by mirroring at the corner pixels' centres or at the outer edges.
template <class T>
void reflect(T* x, int64_t n, int64_t size, bool corners) {
  const T low = corners ? T(0) : T(-0.5), span = static_cast<T>(corners ? std::max<int64_t>(size - 1, 1) : size), last = static_cast<T>(size - 1);
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
  using V = Vector<T>;
  for (int64_t i = 0; i < n; i += V::kLanes) V::store(x + i, V::min(V::all(high), V::max(V::all(low), V::load(x + i))));
}

template <class T>
void place(T* x, int64_t n, int64_t size, Padding padding, bool corners) {
  if (padding == Padding::kBorder) limit(x, n, T(0), static_cast<T>(size - 1));
  if (padding == Padding::kReflection) reflect(x, n, size, corners);
}

// Of each position the pair of pixels to read along an axis, as its first one, and their weights, 0 where they are outside.
template <class T>
void pair_up(const T* x, int64_t n, int64_t size, int32_t* first, T* weight0, T* weight1) {
  using V = Vector<T>;
  const auto zero = V::all(0), one = V::all(1), end = V::all(static_cast<T>(size - 1)), last = V::all(static_cast<T>(std::max<int64_t>(size - 2, 0)));
  const auto least = V::all(-2), greatest = V::all(static_cast<T>(size + 1));
  for (int64_t i = 0; i < n; i += V::kLanes) {
    const auto given = V::load(x + i);
    if (size > 1 && V::all_of((given >= zero) & (given <= end))) {
      const auto from = V::min(V::floor(given), last), fraction = given - from;
      V::store_whole(first + i, from);
      V::store(weight0 + i, one - fraction);
      V::store(weight1 + i, fraction);
      continue;
    }
    const auto position = V::min(V::max(given, least), greatest);  // one pixel outside is as empty as a thousand; not a number is, too
    const auto pixel = V::floor(position), fraction = position - pixel, from = V::min(V::max(pixel, zero), last);
    const auto near = V::where((pixel >= zero) & (pixel <= end), one - fraction), far = V::where((pixel >= -one) & (pixel < end), fraction);
    // Before the first pixel the second of the two is the pair's first, and at the last pixel the first is the pair's second.
    V::store_whole(first + i, from);
    V::store(weight0 + i, V::where(pixel == from, near) + V::where(pixel < from, far));
    V::store(weight1 + i, V::where(pixel == from, far) + V::where(pixel > from, near));
  }
}

// Where a row is read forwards and not by larger steps than one, the pixels at indices lie among eight in a row: how far each is from the first.
inline __m256i from_first(const int32_t* index) {
  return _mm256_sub_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(index)), _mm256_set1_epi32(*index));
}

inline bool among_eight(__m256i from_first) { return _mm256_testz_si256(from_first, _mm256_set1_epi32(~7)); }

// Puts weights of pairs side by side.
inline void store_pairs(float* p, __m256 first, __m256 second) {
  const __m256 low = _mm256_unpacklo_ps(first, second), high = _mm256_unpackhi_ps(first, second);
  _mm256_storeu_ps(p, _mm256_permute2f128_ps(low, high, 0x20));
  _mm256_storeu_ps(p + 8, _mm256_permute2f128_ps(low, high, 0x31));
}

inline void store_pairs(double* p, __m256d first, __m256d second) {
  const __m256d low = _mm256_unpacklo_pd(first, second), high = _mm256_unpackhi_pd(first, second);
  _mm256_storeu_pd(p, _mm256_permute2f128_pd(low, high, 0x20));
  _mm256_storeu_pd(p + 4, _mm256_permute2f128_pd(low, high, 0x31));
}

template <class T>
void bilinear_taps(const T* x, const T* y, int64_t n, int64_t height, int64_t width, int64_t stride, Neighbours<T>& taps) {
  using V = Vector<T>;
  constexpr int64_t lanes = V::kLanes;
  int32_t column[kRun], row[kRun];
  T left[kRun], right[kRun], top[kRun], bottom[kRun];
  pair_up(x, n, width, column, left, right);
  pair_up(y, n, height, row, top, bottom);
  for (int64_t i = 0; i < n; ++i) taps.index[i] = row[i] * static_cast<int32_t>(stride) + column[i];
  const int64_t last = (height - 2) * stride + width - 9;  // the last pixel that has nine in its row and below
  for (int64_t i = 0; i < n; i += lanes) {
    const auto first = V::load(left + i), second = V::load(right + i), above = V::load(top + i), below = V::load(bottom + i);
    bool near = false;
    if constexpr (lanes == 8) near = i + lanes <= n && taps.index[i] <= last && among_eight(from_first(taps.index + i));
    taps.near[i / lanes] = near;
    T *const upper = taps.upper + 2 * i, *const lower = taps.lower + 2 * i;
    if (near) {
      V::store(upper, above * first);
      V::store(upper + lanes, above * second);
      V::store(lower, below * first);
      V::store(lower + lanes, below * second);
    } else {
      store_pairs(upper, above * first, above * second);
      store_pairs(lower, below * first, below * second);
    }
  }
}

inline __m256 pairs(const float* p, const int32_t* index) {
  const auto two = [&](int64_t i) {
    double low, high;  // two pixels each, at any address
    std::memcpy(&low, p + index[i], sizeof low);
    std::memcpy(&high, p + index[i + 1], sizeof high);
    return _mm_castpd_ps(_mm_set_pd(high, low));
  };
  return _mm256_set_m128(two(2), two(0));
}

inline __m256d pairs(const double* p, const int32_t* index) { return _mm256_set_m128d(_mm_loadu_pd(p + index[1]), _mm_loadu_pd(p + index[0])); }

inline __m256 sum_pairs(__m256 a, __m256 b) {
  return _mm256_castpd_ps(_mm256_permute4x64_pd(_mm256_castps_pd(_mm256_hadd_ps(a, b)), 0b11011000));
}

inline __m256d sum_pairs(__m256d a, __m256d b) { return _mm256_permute4x64_pd(_mm256_hadd_pd(a, b), 0b11011000); }

template <class T>
void bilinear(const T* plane, int64_t stride, const Neighbours<T>& taps, int64_t n, T* out) {
  using V = Vector<T>;
  constexpr int64_t lanes = V::kLanes;
  const T* const below = plane + stride;
  const auto weighted = [&](int64_t i) {
    return pairs(plane, taps.index + i) * V::load(taps.upper + 2 * i) + pairs(below, taps.index + i) * V::load(taps.lower + 2 * i);
  };
  int64_t i = 0;
  for (; i + lanes <= n; i += lanes) {
    if constexpr (lanes == 8) {
      if (taps.near[i / lanes]) {
        const T *const a = plane + taps.index[i], *const b = a + stride, *const upper = taps.upper + 2 * i, *const lower = taps.lower + 2 * i;
        const __m256i from = from_first(taps.index + i);
        const auto first = V::pick(V::load(a), from) * V::load(upper) + V::pick(V::load(b), from) * V::load(lower);
        const auto second = V::pick(V::load(a + 1), from) * V::load(upper + lanes) + V::pick(V::load(b + 1), from) * V::load(lower + lanes);
        V::store(out + i, first + second);
        continue;
      }
    }
    V::store(out + i, sum_pairs(weighted(i), weighted(i + lanes / 2)));
  }
  for (; i < n; ++i) {
    const T *const a = plane + taps.index[i], *const b = below + taps.index[i];
    out[i] = (a[0] * taps.upper[2 * i] + b[0] * taps.lower[2 * i]) + (a[1] * taps.upper[2 * i + 1] + b[1] * taps.lower[2 * i + 1]);
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

// To the nearest whole number, halves to the even one: by adding a number so large that no fraction is left. Unlike nearbyint it is vectorised.
inline float rounded(float x) { return (x + 12582912.0f) - 12582912.0f; }
inline double rounded(double x) { return (x + 6755399441055744.0) - 6755399441055744.0; }

// The nearest pixels, halves to the even one, and as weight 1, or 0 outside.
template <class T>
void nearest_taps(const T* x, const T* y, int64_t n, int64_t height, int64_t width, int64_t stride, Neighbours<T>& taps) {
  const auto right = static_cast<T>(width - 1), bottom = static_cast<T>(height - 1);
  const auto limited = [](T x, T last) {  // as a number, for not every one is a pixel's; what is not a number becomes 0
    const T above = x > 0 ? x : T(0);
    return above < last ? above : last;
  };
  for (int64_t i = 0; i < n; ++i) {
    const T column = rounded(x[i]), row = rounded(y[i]), c = limited(column, right), r = limited(row, bottom);
    taps.index[i] = static_cast<int32_t>(r) * static_cast<int32_t>(stride) + static_cast<int32_t>(c);
    taps.upper[i] = (c == column) & (r == row) ? T(1) : T(0);
  }
}

// The pixels at indices, by one load where they lie among eight.
inline __m256 pixels(const float* plane, const int32_t* index, int64_t size) {
  const __m256i from = from_first(index);
  if (among_eight(from) && *index + 8 <= size) return Vector<float>::pick(Vector<float>::load(plane + *index), from);
  return Vector<float>::gather(plane, index);
}

inline __m256d pixels(const double* plane, const int32_t* index, int64_t) { return Vector<double>::gather(plane, index); }

template <class T>
void nearest(const T* plane, int64_t size, const Neighbours<T>& taps, int64_t n, T* out) {
  using V = Vector<T>;
  int64_t i = 0;
  for (; i + V::kLanes <= n; i += V::kLanes) V::store(out + i, pixels(plane, taps.index + i, size) * V::load(taps.upper + i));
  for (; i < n; ++i) out[i] = plane[taps.index[i]] * taps.upper[i];
}

// Has pixels on their way that are read a row later: an image of some megabytes is read across its rows, which the CPU does not foresee.
template <class T>
void prefetch(const T* plane, const int32_t* index, int64_t n) {
  for (int64_t i = 0; i < n; i += 8) _mm_prefetch(reinterpret_cast<const char*>(plane + index[i]), _MM_HINT_T0);
}

// Samples where positions(image, row, column, n, x, y) says.
template <class T, class Positions>
void sample_at(const T* source, Images images, int64_t out_height, int64_t out_width, Interpolation mode, Padding padding, bool corners, T* out,
               const Positions& positions) {
  const int64_t height = images.height, width = images.width, planes = images.count * images.channels;
  int64_t stride = width, plane_size = height * width;
  std::vector<T> widened;
  if (height < 2 || width < 2) {  // where there is no second row or column to load, one with no weight
    stride = width + 1;
    plane_size = (height + 1) * stride;
    widened.resize(static_cast<size_t>(planes * plane_size));
    for (int64_t p = 0; p < planes; ++p)
      for (int64_t y = 0; y < height; ++y) std::copy_n(source + (p * height + y) * width, width, widened.data() + p * plane_size + y * stride);
    source = widened.data();
  }
  const int64_t blocks_y = (out_height + kRows - 1) / kRows, blocks_x = (out_width + kRun - 1) / kRun;
#pragma omp parallel for
  for (int64_t block = 0; block < images.count * blocks_y * blocks_x; ++block) {
    const int64_t left = block % blocks_x * kRun, top = block / blocks_x % blocks_y * kRows, image = block / blocks_x / blocks_y;
    const int64_t n = std::min(kRun, out_width - left);
    const int64_t bottom = std::min(top + kRows, out_height);
    Neighbours<T> rows[2];
    const auto find = [&](int64_t row) {
      T x[kRun], y[kRun];
      positions(image, row, left, n, x, y);
      place(x, n, width, padding, corners);
      place(y, n, height, padding, corners);
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
        for (int64_t c = 0; c < images.channels; ++c) prefetch(source + (image * images.channels + c) * plane_size + below, next, n);
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
void sample(const T* source, Images images, const T* x, const T* y, int64_t out_height, int64_t out_width, Interpolation mode, Padding padding,
            bool corners, T* out) {
  sample_at(source, images, out_height, out_width, mode, padding, corners, out, [&](int64_t image, int64_t row, int64_t column, int64_t n, T* to_x, T* to_y) {
    const int64_t start = (image * out_height + row) * out_width + column;
    std::copy_n(x + start, n, to_x);
    std::copy_n(y + start, n, to_y);
  });
}

template <class T>
void sample_projective(const T* source, Images images, const T* matrices, int64_t out_height, int64_t out_width, Interpolation mode, Padding padding,
                       bool corners, T* out) {
  sample_at(source, images, out_height, out_width, mode, padding, corners, out, [&](int64_t image, int64_t row, int64_t column, int64_t n, T* x, T* y) {
    const T *const m = matrices + 9 * image, v = static_cast<T>(row);
    for (int64_t i = 0; i < n; ++i) {
      const T u = static_cast<T>(column + i), depth = m[6] * u + m[7] * v + m[8];
      const T divisor = std::abs(depth) > T(1e-8) ? depth : T(1e-8);
      x[i] = (m[0] * u + m[1] * v + m[2]) / divisor;
      y[i] = (m[3] * u + m[4] * v + m[5]) / divisor;
    }
  });
}

template <class T>
void sample_patches(const T* pixels, Images rows, const int64_t* start, const int64_t* height, const int64_t* width, const T* frames, int64_t frames_per_row,
                    int64_t side, T* out) {
  const int64_t channels = rows.channels, length = rows.height * rows.width, area = side * side;
  std::vector<T> across(static_cast<size_t>(area)), down(across);  // where a patch's pixels are in its frame
  for (int64_t k = 0; k < area; ++k) {
    across[static_cast<size_t>(k)] = static_cast<T>(2 * (k % side) + 1) / static_cast<T>(side) - 1;
    down[static_cast<size_t>(k)] = static_cast<T>(2 * (k / side) + 1) / static_cast<T>(side) - 1;
  }
#pragma omp parallel for
  for (int64_t i = 0; i < rows.count * frames_per_row; ++i) {
    const int64_t row = i / frames_per_row, frame = i % frames_per_row;
    const T* const m = frames + 6 * i;
    const T* const image = pixels + row * channels * length + start[i];
    Neighbours<T> taps;
    T x[kRun], y[kRun];
    // Else no sum of products of theirs with numbers from -1 to 1 is NaN, and all patches but broken ones are read without looking.
    const bool broken = !std::all_of(m, m + 6, [](T v) { return std::abs(v) < std::numeric_limits<T>::max() / 4; });
    const bool point = m[0] == 0 && m[1] == 0 && m[3] == 0 && m[4] == 0;  // an empty slot's frame: all pixels are the first
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

template void sample(const float*, Images, const float*, const float*, int64_t, int64_t, Interpolation, Padding, bool, float*);
template void sample(const double*, Images, const double*, const double*, int64_t, int64_t, Interpolation, Padding, bool, double*);
template void sample_patches(const float*, Images, const int64_t*, const int64_t*, const int64_t*, const float*, int64_t, int64_t, float*);
template void sample_patches(const double*, Images, const int64_t*, const int64_t*, const int64_t*, const double*, int64_t, int64_t, double*);
template void sample_projective(const float*, Images, const float*, int64_t, int64_t, Interpolation, Padding, bool, float*);
template void sample_projective(const double*, Images, const double*, int64_t, int64_t, Interpolation, Padding, bool, double*);

}  // namespace chiasm::kernels
