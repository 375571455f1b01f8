// Resizing: each pixel is a weighted sum of a run of pixels, along the columns and along the rows.
#include <type_traits>

#include "rows.h"

namespace chiasm::kernels {
namespace {

constexpr int64_t kRows = 32;

// Those of 2 n values at even and at odd places; `ordered` puts their order right, which is the same for both.
inline __m256 evens(__m256 a, __m256 b) { return _mm256_shuffle_ps(a, b, 0b10001000); }
inline __m256 odds(__m256 a, __m256 b) { return _mm256_shuffle_ps(a, b, 0b11011101); }
inline __m256 ordered(__m256 v) { return _mm256_castpd_ps(_mm256_permute4x64_pd(_mm256_castps_pd(v), 0b11011000)); }
inline __m256d evens(__m256d a, __m256d b) { return _mm256_unpacklo_pd(a, b); }
inline __m256d odds(__m256d a, __m256d b) { return _mm256_unpackhi_pd(a, b); }
inline __m256d ordered(__m256d v) { return _mm256_permute4x64_pd(v, 0b11011000); }

// One axis: the first pixel of each position's run, and the runs' weights, tap after tap.
template <class T>
struct Axis {
  static constexpr int64_t kLanes = Vector<T>::kLanes;
  // Of a vector of positions: kDoubled where their runs begin at every second pixel, kMirrored where besides all their weights are symmetric.
  enum class Runs : char { kAny, kDoubled, kMirrored };

  int64_t taps, count;
  std::vector<int32_t> first;
  std::vector<T> weights;       // taps x count
  std::vector<bool> symmetric;  // of each position: whether its weights are
  std::vector<Runs> runs;

  // From `given` taps a position, each with its own pixel: pixels that borders repeat are one tap of the run.
  Axis(const int32_t* index, const T* given, int64_t per_position, int64_t positions, int64_t size) : taps(1), count(positions), first(positions) {
    for (int64_t i = 0; i < positions; ++i) {
      int32_t low = index[i * per_position], high = low;
      for (int64_t k = 0; k < per_position; ++k) {
        if (given[i * per_position + k] == 0) continue;
        low = std::min(low, index[i * per_position + k]);
        high = std::max(high, index[i * per_position + k]);
      }
      first[i] = low;
      taps = std::max<int64_t>(taps, high - low + 1);
    }
    weights.assign(static_cast<size_t>(taps * positions), T(0));
    for (int64_t i = 0; i < positions; ++i) {
      first[i] = static_cast<int32_t>(std::min<int64_t>(first[i], size - taps));  // the run ends inside
      for (int64_t k = 0; k < per_position; ++k) {
        const T weight = given[i * per_position + k];
        if (weight != 0) weights[(index[i * per_position + k] - first[i]) * positions + i] += weight;
      }
      bool same = true;
      for (int64_t k = 0; k < taps / 2; ++k) same = same && weights[k * positions + i] == weights[(taps - 1 - k) * positions + i];
      symmetric.push_back(same);
    }
  }

  // For along_row: finds `runs`, and puts the weights there in the order in which evens and odds give the pixels (`ordered` undoes itself).
  void find_runs(int64_t size) {
    for (int64_t i = 0; i + kLanes <= count; i += kLanes) {
      bool every_second = first[i] + 2 * (kLanes - 1) + taps + taps % 2 <= size;
      for (int64_t k = 1; k < kLanes; ++k) every_second = every_second && first[i + k] == first[i] + 2 * k;
      const bool mirrored = std::all_of(symmetric.begin() + i, symmetric.begin() + i + kLanes, [](bool same) { return same; });
      runs.push_back(!every_second ? Runs::kAny : mirrored ? Runs::kMirrored : Runs::kDoubled);
      for (int64_t k = 0; every_second && k < taps; ++k) {
        T* const weight = weights.data() + k * count + i;
        Vector<T>::store(weight, ordered(Vector<T>::load(weight)));
      }
    }
  }
};

// The loops over taps are unrolled for kTaps, an even number, which is 0 for any number.
template <class T, int kTaps>
void along_row(const T* row, const Axis<T>& axis, T* out) {
  using V = Vector<T>;
  using Runs = typename Axis<T>::Runs;
  const int64_t n = axis.count, taps = kTaps ? kTaps : axis.taps;
  const int32_t* const first = axis.first.data();
  int64_t i = 0;
  for (; i + V::kLanes <= n; i += V::kLanes) {
    const T* const weights = axis.weights.data() + i;
    auto sum = V::all(0);
    if (const Runs runs = axis.runs[i / V::kLanes]; kTaps && runs == Runs::kMirrored) {
      typename V::Type pixels[kTaps + 1];
#pragma GCC unroll 8
      for (int64_t k = 0; k < kTaps; k += 2) {
        const T* const pixel = row + first[i] + k;
        const auto a = V::load(pixel), b = V::load(pixel + V::kLanes);
        pixels[k] = evens(a, b);
        pixels[k + 1] = odds(a, b);
      }
#pragma GCC unroll 8
      for (int64_t k = 0; k < kTaps / 2; ++k) sum += (pixels[k] + pixels[kTaps - 1 - k]) * V::load(weights + k * n);
      sum = ordered(sum);
    } else if (runs != Runs::kAny) {
#pragma GCC unroll 8
      for (int64_t k = 0; k < taps; k += 2) {
        const T* const pixel = row + first[i] + k;
        const auto a = V::load(pixel), b = V::load(pixel + V::kLanes);
        sum += evens(a, b) * V::load(weights + k * n);
        if (k + 1 < taps) sum += odds(a, b) * V::load(weights + (k + 1) * n);
      }
      sum = ordered(sum);
    } else {
#pragma GCC unroll 8
      for (int64_t k = 0; k < taps; ++k) sum += V::gather(row + k, first + i) * V::load(weights + k * n);
    }
    V::store(out + i, sum);
  }
  for (; i < n; ++i) {
    T sum = 0;
    for (int64_t k = 0; k < taps; ++k) sum += row[first[i] + k] * axis.weights[k * n + i];
    out[i] = sum;
  }
}

// out = the sum of the rows first + k * stride, k < taps, by the weights of position i.
template <class T, int kTaps>
void down_columns(const T* first, int64_t stride, const Axis<T>& axis, int64_t i, int64_t n, T* out) {
  using V = Vector<T>;
  const int64_t taps = kTaps ? kTaps : axis.taps;
  const T* const weights = axis.weights.data() + i;
  int64_t x = 0;
  for (; kTaps && axis.symmetric[i] && x + V::kLanes <= n; x += V::kLanes) {
    auto sum = V::all(0);
#pragma GCC unroll 8
    for (int64_t k = 0; k < kTaps / 2; ++k)
      sum += (V::load(first + k * stride + x) + V::load(first + (kTaps - 1 - k) * stride + x)) * V::all(weights[k * axis.count]);
    V::store(out + x, sum);
  }
  for (; x + 2 * V::kLanes <= n; x += 2 * V::kLanes) {
    auto weight = V::all(weights[0]);
    auto a = V::load(first + x) * weight, b = V::load(first + x + V::kLanes) * weight;
#pragma GCC unroll 8
    for (int64_t k = 1; k < taps; ++k) {
      weight = V::all(weights[k * axis.count]);
      a += V::load(first + k * stride + x) * weight;
      b += V::load(first + k * stride + x + V::kLanes) * weight;
    }
    V::store(out + x, a);
    V::store(out + x + V::kLanes, b);
  }
  for (; x < n; ++x) {
    T sum = first[x] * weights[0];
    for (int64_t k = 1; k < taps; ++k) sum += first[k * stride + x] * weights[k * axis.count];
    out[x] = sum;
  }
}

// Calls choose with the number of taps that a loop is to be unrolled for.
template <class Choose>
auto for_taps(int64_t taps, const Choose& choose) {
  switch (taps) {
    case 2: return choose(std::integral_constant<int, 2>());
    case 4: return choose(std::integral_constant<int, 4>());
    case 6: return choose(std::integral_constant<int, 6>());
    case 8: return choose(std::integral_constant<int, 8>());
    default: return choose(std::integral_constant<int, 0>());
  }
}

}  // namespace

template <class T>
void resample(const T* x, Planes planes, const int32_t* index_y, const T* weight_y, int64_t taps_y, int64_t out_height, const int32_t* index_x,
              const T* weight_x, int64_t taps_x, int64_t out_width, T* out) {
  const int64_t height = planes.height, width = planes.width, blocks = (out_height + kRows - 1) / kRows;
  const Axis<T> down(index_y, weight_y, taps_y, out_height, height);
  Axis<T> across(index_x, weight_x, taps_x, out_width, width);
  across.find_runs(width);
  const auto rows_loop = for_taps(across.taps, [](auto taps) { return &along_row<T, taps.value>; });
  const auto columns_loop = for_taps(down.taps, [](auto taps) { return &down_columns<T, taps.value>; });
  // Shrinking sums rows first, so that fewer are resampled; growing resamples the fewer rows that there are, a block's at once.
  const bool shrinks = out_height <= height;
  const auto span = [&](int64_t block) {  // the rows that a block of the output reads
    const auto begin = down.first.begin() + block * kRows, end = down.first.begin() + std::min((block + 1) * kRows, out_height);
    const auto [low, high] = std::minmax_element(begin, end);
    return std::pair<int64_t, int64_t>(*low, *high + down.taps);
  };
  int64_t rows = 1;
  for (int64_t b = 0; !shrinks && b < blocks; ++b) rows = std::max(rows, span(b).second - span(b).first);
  const int64_t room = rows * std::max(width, out_width);
  const std::unique_ptr<T[]> scratch(new T[static_cast<size_t>(room * omp_get_max_threads())]);
#pragma omp parallel for
  for (int64_t i = 0; i < planes.count * blocks; ++i) {
    const int64_t block = i % blocks, bottom = std::min((block + 1) * kRows, out_height);
    const T* const plane = x + i / blocks * height * width;
    T* const target = out + i / blocks * out_height * out_width;
    T* const own = scratch.get() + room * omp_get_thread_num();
    const auto [low, high] = span(block);
    for (int64_t y = low; !shrinks && y < high; ++y) rows_loop(plane + y * width, across, own + (y - low) * out_width);
    for (int64_t y = block * kRows; y < bottom; ++y) {
      if (shrinks) {
        const T* row = plane + down.first[y] * width;
        if (down.taps > 1 || down.weights[y] != 1) {
          columns_loop(row, width, down, y, width, own);
          row = own;
        }
        rows_loop(row, across, target + y * out_width);
      } else {
        columns_loop(own + (down.first[y] - low) * out_width, out_width, down, y, out_width, target + y * out_width);
      }
    }
  }
}

template void resample(const float*, Planes, const int32_t*, const float*, int64_t, int64_t, const int32_t*, const float*, int64_t, int64_t, float*);
template void resample(const double*, Planes, const int32_t*, const double*, int64_t, int64_t, const int32_t*, const double*, int64_t, int64_t, double*);

}  // namespace chiasm::kernels
