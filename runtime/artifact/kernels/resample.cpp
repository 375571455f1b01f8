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
  // Of a vector of positions: kDoubled where their runs begin at every second pixel, kMirrored where besides all their weights are symmetric;
  // kNear and kWide where they begin inside one vector of pixels or two. Gathering pixels, for kAny, takes several times as long.
  enum class Runs : char { kAny, kWide, kNear, kDoubled, kMirrored };

  int64_t taps, count;
  bool copies;  // each position is a pixel as it is
  std::vector<int32_t> first;
  std::vector<T> weights;       // taps x count
  std::vector<bool> symmetric;  // of each position: whether its weights are
  // Of each vector of positions:
  std::vector<Runs> runs;
  std::vector<int32_t> starts;  // the first run's first pixel
  std::vector<int32_t> lanes;   // for Vector::pick

  // Pixels that borders repeat are one tap of a run.
  Axis(const Taps<T>& given, int64_t size) : taps(1), count(given.count), first(given.count) {
    for (int64_t i = 0; i < count; ++i) {
      int32_t low = given.index[i * given.each], high = low;
      for (int64_t k = i * given.each; k < (i + 1) * given.each; ++k) {
        if (given.weight[k] == 0) continue;
        low = std::min(low, given.index[k]);
        high = std::max(high, given.index[k]);
      }
      first[i] = low;
      taps = std::max<int64_t>(taps, high - low + 1);
    }
    weights.assign(static_cast<size_t>(taps * count), T(0));
    for (int64_t i = 0; i < count; ++i) {
      first[i] = static_cast<int32_t>(std::min<int64_t>(first[i], size - taps));  // the run ends inside
      for (int64_t k = i * given.each; k < (i + 1) * given.each; ++k) {
        if (given.weight[k] != 0) weights[(given.index[k] - first[i]) * count + i] += given.weight[k];
      }
      bool same = true;
      for (int64_t k = 0; k < taps / 2; ++k) same = same && weights[k * count + i] == weights[(taps - 1 - k) * count + i];
      symmetric.push_back(same);
    }
    copies = taps == 1 && std::all_of(weights.begin(), weights.end(), [](T weight) { return weight == 1; });
  }

  // For along_row: finds `runs`, and puts the weights of doubled ones in the order in which evens and odds give the pixels (`ordered` undoes itself).
  void find_runs(int64_t size) {
    lanes.resize(static_cast<size_t>(count / kLanes * 8));
    for (int64_t i = 0; i + kLanes <= count; i += kLanes) {
      starts.push_back(first[i]);
      int32_t from[kLanes];
      bool every_second = first[i] + 2 * (kLanes - 1) + taps + taps % 2 <= size;
      int32_t furthest = 0;
      bool rising = true;
      for (int64_t k = 0; k < kLanes; ++k) {
        from[k] = first[i + k] - first[i];
        every_second = every_second && from[k] == 2 * k;
        rising = rising && from[k] >= 0;
        furthest = std::max(furthest, from[k]);
      }
      const int64_t vectors = furthest / kLanes + 1;  // of pixels, from the first run's on
      if (every_second) {
        const bool mirrored = std::all_of(symmetric.begin() + i, symmetric.begin() + i + kLanes, [](bool same) { return same; });
        runs.push_back(mirrored ? Runs::kMirrored : Runs::kDoubled);
        for (int64_t k = 0; k < taps; ++k) {
          T* const weight = weights.data() + k * count + i;
          Vector<T>::store(weight, ordered(Vector<T>::load(weight)));
        }
      } else if (rising && vectors <= 2 && first[i] + taps - 1 + vectors * kLanes <= size) {
        runs.push_back(vectors == 1 ? Runs::kNear : Runs::kWide);
        store_lanes<T>(from, lanes.data() + i / kLanes * 8);
      } else {
        runs.push_back(Runs::kAny);
      }
    }
  }
};

// The loops over taps are unrolled for kTaps, an even number, which is 0 for any number, or 1 for an axis that copies.
template <class T, int kTaps>
void along_row(const T* row, const Axis<T>& axis, T* out) {
  using V = Vector<T>;
  using Runs = typename Axis<T>::Runs;
  const int64_t n = axis.count, taps = kTaps ? kTaps : axis.taps;
  const int32_t *const first = axis.first.data(), *const starts = axis.starts.data(), *const lanes = axis.lanes.data();
  const T* const weights = axis.weights.data();
  const Runs* const runs = axis.runs.data();
  int64_t i = 0;
  for (; i + V::kLanes <= n; i += V::kLanes) {
    const auto weight = [=](int64_t k) { return kTaps == 1 ? V::all(1) : V::load(weights + k * n + i); };
    const Runs kind = runs[i / V::kLanes];
    const T* const start = row + starts[i / V::kLanes];
    // With one tap it is memory that takes the time: the next row is on its way.
    if (kTaps == 1) _mm_prefetch(reinterpret_cast<const char*>(start + first[n - 1]), _MM_HINT_T0);
    auto sum = V::all(0);
    if (kTaps > 1 && kind == Runs::kMirrored) {
      typename V::Type pixels[kTaps + 1];
#pragma GCC unroll 8
      for (int64_t k = 0; k < kTaps; k += 2) {
        const T* const pixel = start + k;
        const auto a = V::load(pixel), b = V::load(pixel + V::kLanes);
        pixels[k] = evens(a, b);
        pixels[k + 1] = odds(a, b);
      }
#pragma GCC unroll 8
      for (int64_t k = 0; k < kTaps / 2; ++k) sum += (pixels[k] + pixels[kTaps - 1 - k]) * weight(k);
      sum = ordered(sum);
    } else if (kind == Runs::kMirrored || kind == Runs::kDoubled) {
#pragma GCC unroll 8
      for (int64_t k = 0; k < taps; k += 2) {
        const T* const pixel = start + k;
        const auto a = V::load(pixel), b = V::load(pixel + V::kLanes);
        sum += evens(a, b) * weight(k);
        if (k + 1 < taps) sum += odds(a, b) * weight(k + 1);
      }
      sum = ordered(sum);
    } else if (kind == Runs::kNear) {
      const auto from = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(lanes + i / V::kLanes * 8));
#pragma GCC unroll 8
      for (int64_t k = 0; k < taps; ++k) sum += V::pick(V::load(start + k), from) * weight(k);
    } else if (kind == Runs::kWide) {
      const auto from = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(lanes + i / V::kLanes * 8));
#pragma GCC unroll 8
      for (int64_t k = 0; k < taps; ++k) {
        const T* const pixel = start + k;
        sum += V::pick(V::load(pixel), V::load(pixel + V::kLanes), from) * weight(k);
      }
    } else {
#pragma GCC unroll 8
      for (int64_t k = 0; k < taps; ++k) sum += V::gather(row + k, first + i) * weight(k);
    }
    V::store(out + i, sum);
  }
  for (; i < n; ++i) {
    T sum = 0;
    for (int64_t k = 0; k < taps; ++k) sum += row[first[i] + k] * weights[k * n + i];
    out[i] = sum;
  }
}

// out = the sum of the rows first + k * stride, k < taps, by the weights of position i. What the loops need is in values of their own: it would
// be loaded again after every store of a vector.
template <class T, int kTaps>
void down_columns(const T* first, int64_t stride, const Axis<T>& axis, int64_t i, int64_t n, T* out) {
  using V = Vector<T>;
  const int64_t taps = kTaps ? kTaps : axis.taps, count = axis.count;
  const T* const weights = axis.weights.data() + i;
  int64_t x = 0;
  if (kTaps > 1 && axis.symmetric[i]) {
    typename V::Type half[kTaps / 2 + 1];
    for (int64_t k = 0; k < kTaps / 2; ++k) half[k] = V::all(weights[k * count]);
    for (; x + V::kLanes <= n; x += V::kLanes) {
      // The rows that the next position adds to these are on their way while these are summed.
      for (int64_t k = 0; k < 2; ++k) _mm_prefetch(reinterpret_cast<const char*>(first + (kTaps + k) * stride + x), _MM_HINT_T0);
      auto sum = V::all(0);
#pragma GCC unroll 8
      for (int64_t k = 0; k < kTaps / 2; ++k) sum += (V::load(first + k * stride + x) + V::load(first + (kTaps - 1 - k) * stride + x)) * half[k];
      V::store(out + x, sum);
    }
  }
  for (; x + 2 * V::kLanes <= n; x += 2 * V::kLanes) {
    auto weight = V::all(weights[0]);
    auto a = V::load(first + x) * weight, b = V::load(first + x + V::kLanes) * weight;
#pragma GCC unroll 8
    for (int64_t k = 1; k < taps; ++k) {
      weight = V::all(weights[k * count]);
      a += V::load(first + k * stride + x) * weight;
      b += V::load(first + k * stride + x + V::kLanes) * weight;
    }
    V::store(out + x, a);
    V::store(out + x + V::kLanes, b);
  }
  for (; x < n; ++x) {
    T sum = first[x] * weights[0];
    for (int64_t k = 1; k < taps; ++k) sum += first[k * stride + x] * weights[k * count];
    out[x] = sum;
  }
}

// Calls choose with the number of taps that an axis's loop is to be unrolled for.
template <class T, class Choose>
auto for_taps(const Axis<T>& axis, const Choose& choose) {
  if (axis.copies) return choose(std::integral_constant<int, 1>());
  switch (axis.taps) {
    case 2: return choose(std::integral_constant<int, 2>());
    case 4: return choose(std::integral_constant<int, 4>());
    case 6: return choose(std::integral_constant<int, 6>());
    case 8: return choose(std::integral_constant<int, 8>());
    default: return choose(std::integral_constant<int, 0>());
  }
}

}  // namespace

template <class T>
void resample(const T* x, Planes planes, const Taps<T>& taps_down, const Taps<T>& taps_across, T* out) {
  const int64_t height = planes.height, width = planes.width, out_height = taps_down.count, out_width = taps_across.count;
  const int64_t blocks = (out_height + kRows - 1) / kRows;
  const Axis<T> down(taps_down, height);
  Axis<T> across(taps_across, width);
  across.find_runs(width);
  const auto rows_loop = for_taps(across, [](auto taps) { return &along_row<T, taps.value>; });
  const auto columns_loop = for_taps(down, [](auto taps) { return &down_columns<T, taps.value>; });
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
        if (!down.copies) {
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

template void resample(const float*, Planes, const Taps<float>&, const Taps<float>&, float*);
template void resample(const double*, Planes, const Taps<double>&, const Taps<double>&, double*);

}  // namespace chiasm::kernels
