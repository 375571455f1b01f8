// Counting levels and looking them up: loops that follow the data, which compiled tensor code does by atomic additions and by gathers
// of 64-bit indices.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "rows.h"

namespace chiasm::kernels {
namespace {

// Four tables in turn: an addition to a bin does not wait for the one before it, which often is to the same bin.
constexpr int64_t kTables = 4;

// Counts those of n numbers that are bins, or all of them where they are known to be.
template <bool known = false, class Index>
void count(const Index* index, int64_t n, int64_t bins, int32_t* tables) {
  int32_t *const a = tables, *const b = a + bins, *const c = b + bins, *const d = c + bins;
  const auto valid = [bins](Index i) { return known || static_cast<uint64_t>(i) < static_cast<uint64_t>(bins); };
  int64_t k = 0;
  for (; k + kTables <= n; k += kTables) {
    if (valid(index[k])) ++a[index[k]];
    if (valid(index[k + 1])) ++b[index[k + 1]];
    if (valid(index[k + 2])) ++c[index[k + 2]];
    if (valid(index[k + 3])) ++d[index[k + 3]];
  }
  for (; k < n; ++k)
    if (valid(index[k])) ++a[index[k]];
}

// Shares the counting of rows among threads: body(row, first, n, tables) counts n numbers into kTables tables of zeros.
template <class Body>
void count_rows(int64_t rows, int64_t n, int64_t bins, int32_t* counts, const Body& body) {
  // A task's own counting outweighs adding its tables to the others'.
  const int64_t size = std::max<int64_t>(65536, 32 * bins), chunks = std::max<int64_t>(1, (n + size - 1) / size);
  const std::unique_ptr<int32_t[]> scratch(new int32_t[static_cast<size_t>(kTables * bins * omp_get_max_threads())]);
  std::fill_n(counts, rows * bins, 0);
#pragma omp parallel
  {
    int32_t* const tables = scratch.get() + kTables * bins * omp_get_thread_num();
#pragma omp for
    for (int64_t i = 0; i < rows * chunks; ++i) {
      const int64_t row = i / chunks, first = i % chunks * size;
      std::fill_n(tables, kTables * bins, 0);
      body(row, first, std::min(size, n - first), tables);
      for (int64_t k = 0; k < bins; ++k) {
        const int32_t sum = tables[k] + tables[bins + k] + tables[2 * bins + k] + tables[3 * bins + k];
        if (sum) {
#pragma omp atomic
          counts[row * bins + k] += sum;
        }
      }
    }
  }
}

}  // namespace

template <class Index>
void count_each(const Index* index, int64_t rows, int64_t n, int64_t bins, int32_t* counts) {
  count_rows(rows, n, bins, counts, [&](int64_t row, int64_t first, int64_t size, int32_t* tables) { count(index + row * n + first, size, bins, tables); });
}

namespace {

// The least and the greatest of n > 0 values, and whether one is NaN.
template <class T>
struct Extent {
  T least, greatest;
  bool undefined;
};

template <class T>
Extent<T> extent(const T* x, int64_t n) {
  using V = Vector<T>;
  T least = x[0], greatest = x[0];
  bool undefined = false;
  int64_t k = 0;
  if (n >= 4 * V::kLanes) {
    // Four of each, which do not wait for each other.
    typename V::Type low[4], high[4], order[4];
    for (int i = 0; i < 4; ++i) low[i] = high[i] = order[i] = V::load(x + i * V::kLanes);
    for (; k + 4 * V::kLanes <= n; k += 4 * V::kLanes)
      for (int i = 0; i < 4; ++i) {
        const auto v = V::load(x + k + i * V::kLanes);
        low[i] = V::min(low[i], v);
        high[i] = V::max(high[i], v);
        order[i] += v - v;  // NaN once a value is, or is infinite
      }
    T lows[V::kLanes], highs[V::kLanes];
    V::store(lows, V::min(V::min(low[0], low[1]), V::min(low[2], low[3])));
    V::store(highs, V::max(V::max(high[0], high[1]), V::max(high[2], high[3])));
    least = *std::min_element(lows, lows + V::kLanes);
    greatest = *std::max_element(highs, highs + V::kLanes);
    const auto sum = order[0] + order[1] + order[2] + order[3];
    if (V::any(sum != sum)) undefined = std::any_of(x, x + k, [](T v) { return std::isnan(v); });
  }
  for (; k < n; ++k) {
    least = std::min(least, x[k]);
    greatest = std::max(greatest, x[k]);
    undefined = undefined || std::isnan(x[k]);
  }
  return {least, greatest, undefined};
}

}  // namespace

template <class T>
void extents(const T* x, int64_t rows, int64_t n, T* out) {
  constexpr int64_t size = 65536;
  const int64_t chunks = (n + size - 1) / size;
  std::vector<Extent<T>> parts(static_cast<size_t>(rows * chunks));
#pragma omp parallel for
  for (int64_t i = 0; i < rows * chunks; ++i) {
    const int64_t first = i % chunks * size;
    parts[static_cast<size_t>(i)] = extent(x + i / chunks * n + first, std::min(size, n - first));
  }
  for (int64_t row = 0; row < rows; ++row) {
    Extent<T> all = parts[static_cast<size_t>(row * chunks)];
    for (int64_t i = row * chunks; i < (row + 1) * chunks; ++i) {
      const Extent<T>& part = parts[static_cast<size_t>(i)];
      all = {std::min(all.least, part.least), std::max(all.greatest, part.greatest), all.undefined || part.undefined};
    }
    out[row] = all.undefined ? std::numeric_limits<T>::quiet_NaN() : all.least;
    out[rows + row] = all.undefined ? std::numeric_limits<T>::quiet_NaN() : all.greatest;
  }
}

template void extents(const float*, int64_t, int64_t, float*);
template void extents(const double*, int64_t, int64_t, double*);

template <class T>
void bin_counts(const T* x, const T* low, const T* span, int64_t rows, int64_t n, int64_t bins, int32_t* counts) {
  using V = Vector<T>;
  constexpr int64_t kBlock = 512;
  count_rows(rows, n, bins, counts, [&](int64_t row, int64_t first, int64_t size, int32_t* tables) {
    const T* const values = x + row * n + first;
    const T least = low[row], width = span[row], number = static_cast<T>(bins), last = static_cast<T>(bins - 1);
    int32_t index[kBlock];
    for (int64_t k = 0; k < size; k += kBlock) {
      const int64_t m = std::min(kBlock, size - k);
      // Limited as numbers, for not every one is an integer; max's second operand is what NaN becomes.
      int64_t j = 0;
      for (; j + V::kLanes <= m; j += V::kLanes)
        V::store_whole(index + j, V::min(V::max((V::load(values + k + j) - V::all(least)) / V::all(width) * V::all(number), V::all(0)), V::all(last)));
      for (; j < m; ++j) {
        const T place = (values[k + j] - least) / width * number;
        index[j] = static_cast<int32_t>(place > 0 ? std::min(place, last) : T(0));
      }
      count<true>(index, m, bins, tables);
    }
  });
}

template void bin_counts(const float*, const float*, const float*, int64_t, int64_t, int64_t, int32_t*);
template void bin_counts(const double*, const double*, const double*, int64_t, int64_t, int64_t, int32_t*);

namespace {

__m256 load_eight(const float* p) { return _mm256_loadu_ps(p); }
__m256 load_eight(const double* p) { return _mm256_set_m128(_mm256_cvtpd_ps(_mm256_loadu_pd(p + 4)), _mm256_cvtpd_ps(_mm256_loadu_pd(p))); }

// The levels of eight values, in the lower half.
__m128i eight_levels(__m256 x) {
  // max's second operand is what NaN becomes.
  const __m256 scaled = _mm256_min_ps(_mm256_max_ps(x * 255.0f, _mm256_setzero_ps()), _mm256_set1_ps(255.0f));
  const __m256i whole = _mm256_cvttps_epi32(scaled);
  const __m256i up = (__m256i)(scaled - _mm256_cvtepi32_ps(whole) >= 0.5f);  // -1 or 0
  const __m256i level = _mm256_sub_epi32(whole, up);
  const __m128i shorts = _mm_packus_epi32(_mm256_castsi256_si128(level), _mm256_extracti128_si256(level, 1));
  return _mm_packus_epi16(shorts, shorts);
}

}  // namespace

template <class T>
void to_levels(const T* x, int64_t n, uint8_t* levels) {
  constexpr int64_t kBlock = 16384;
#pragma omp parallel for
  for (int64_t first = 0; first < n; first += kBlock) {
    const int64_t last = std::min(n, first + kBlock);
    int64_t k = first;
    for (; k + 8 <= last; k += 8) _mm_storel_epi64(reinterpret_cast<__m128i*>(levels + k), eight_levels(load_eight(x + k)));
    if (k < last) {
      T rest[8] = {};
      uint8_t bytes[16];
      std::copy(x + k, x + last, rest);
      _mm_storeu_si128(reinterpret_cast<__m128i*>(bytes), eight_levels(load_eight(rest)));
      std::copy_n(bytes, last - k, levels + k);
    }
  }
}

template void to_levels(const float*, int64_t, uint8_t*);
template void to_levels(const double*, int64_t, uint8_t*);

template void count_each(const uint8_t*, int64_t, int64_t, int64_t, int32_t*);
template void count_each(const int32_t*, int64_t, int64_t, int64_t, int32_t*);

template <class T>
void look_up(const T* table, const uint8_t* index, int64_t rows, int64_t n, T* out) {
  constexpr int64_t size = 65536;
  const int64_t chunks = (n + size - 1) / size;
#pragma omp parallel for
  for (int64_t i = 0; i < rows * chunks; ++i) {
    const int64_t row = i / chunks, first = i % chunks * size, last = std::min(n, first + size);
    const T* const entries = table + row * 256;
    for (int64_t k = row * n + first; k < row * n + last; ++k) out[k] = entries[index[k]];
  }
}

template void look_up(const float*, const uint8_t*, int64_t, int64_t, float*);
template void look_up(const double*, const uint8_t*, int64_t, int64_t, double*);

void tile_counts(const uint8_t* levels, Planes planes, int64_t tile_y, int64_t tile_x, int64_t tiles_y, int64_t tiles_x, int32_t* counts) {
  const int64_t tiles = tiles_y * tiles_x;
#pragma omp parallel for
  for (int64_t i = 0; i < planes.count * tiles; ++i) {
    const uint8_t* const plane = levels + i / tiles * planes.height * planes.width;
    const int64_t top = i % tiles / tiles_x * tile_y, left = i % tiles_x * tile_x;
    const int64_t within = std::clamp<int64_t>(planes.width - left, 0, tile_x);
    std::array<int32_t, kTables * 256> tables{};
    for (int64_t y = top; y < top + tile_y; ++y) {
      const uint8_t* const row = plane + inside(y, planes.height, Border::kReflect) * planes.width;
      count(row + left, within, 256, tables.data());
      for (int64_t x = left + within; x < left + tile_x; ++x) ++tables[row[inside(x, planes.width, Border::kReflect)]];
    }
    for (int64_t k = 0; k < 256; ++k) counts[i * 256 + k] = tables[k] + tables[256 + k] + tables[512 + k] + tables[768 + k];
  }
}

void blend_curves(const float* table, int64_t tiles, int64_t tiles_x, const uint8_t* levels, Planes planes, const int64_t* first_y,
                  const int64_t* second_y, const float* weight_y, const int64_t* first_x, const int64_t* second_x, const float* weight_x,
                  uint8_t* out) {
  const int64_t height = planes.height, width = planes.width;
  // Between two tiles' centres every pixel takes the same curves: where each such stretch ends.
  std::vector<int64_t> ends;
  for (int64_t x = 1; x <= width; ++x)
    if (x == width || first_x[x] != first_x[x - 1] || second_x[x] != second_x[x - 1]) ends.push_back(x);
#pragma omp parallel for
  for (int64_t i = 0; i < planes.count * height; ++i) {
    const int64_t y = i % height;
    const float* const curves = table + i / height * tiles * 256;
    const float *const upper = curves + first_y[y] * tiles_x * 256, *const lower = curves + second_y[y] * tiles_x * 256;
    const uint8_t* const in = levels + i * width;
    uint8_t* const target = out + i * width;
    const __m256 below = _mm256_set1_ps(weight_y[y]), above = 1.0f - below;
    int64_t x = 0;
    for (const int64_t end : ends) {
      const int64_t tile = first_x[x], next = second_x[x];
      const float *const a = upper + tile * 256, *const b = upper + next * 256, *const c = lower + tile * 256, *const d = lower + next * 256;
      for (; x + 8 <= end; x += 8) {
        const __m256i level = _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(in + x)));
        const __m256 right = _mm256_loadu_ps(weight_x + x), left = 1.0f - right;
        const __m256 top = _mm256_i32gather_ps(a, level, 4) * left + _mm256_i32gather_ps(b, level, 4) * right;
        const __m256 bottom = _mm256_i32gather_ps(c, level, 4) * left + _mm256_i32gather_ps(d, level, 4) * right;
        const __m256i whole = _mm256_cvtps_epi32(top * above + bottom * below);  // rounds to even
        const __m128i shorts = _mm_packus_epi32(_mm256_castsi256_si128(whole), _mm256_extracti128_si256(whole, 1));
        _mm_storel_epi64(reinterpret_cast<__m128i*>(target + x), _mm_packus_epi16(shorts, shorts));
      }
      for (; x < end; ++x) {
        const float right = weight_x[x], left = 1.0f - right;
        const float top = a[in[x]] * left + b[in[x]] * right, bottom = c[in[x]] * left + d[in[x]] * right;
        const float level = std::nearbyint(top * (1.0f - weight_y[y]) + bottom * weight_y[y]);
        target[x] = level > 0 ? static_cast<uint8_t>(std::min(level, 255.0f)) : uint8_t{0};
      }
    }
  }
}

}  // namespace chiasm::kernels
