// Resizing: each pixel is a weighted sum of a run of pixels, along the columns and along the rows.
#include <type_traits>

#include "declared/resize.h"
#include "resize_taps.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

constexpr int64_t kRows = 32;

// The values from p on, even and odd ones separately.
template <class D>
HWY_INLINE void deinterleave(D d, const hn::TFromD<D>* p, hn::Vec<D>& even, hn::Vec<D>& odd) {
  const auto low = hn::LoadU(d, p), high = hn::LoadU(d, p + hn::Lanes(d));
  even = hn::ConcatEven(d, high, low);
  odd = hn::ConcatOdd(d, high, low);
}

// One axis: the first pixel of each position's run, and the runs' weights, tap after tap.
template <class T>
struct Axis {
  static constexpr int64_t lanes = kLanes<T>;
  // The kind of a vector of positions: kDoubled if the runs begin at every second pixel; kMirrored if also
  // all weights are symmetric; kNear or kWide if the runs begin inside one vector of pixels, or two. kAny
  // gathers pixels, which takes several times as long.
  enum class Runs : char { kAny, kWide, kNear, kDoubled, kMirrored };

  int64_t taps, count;
  bool copies;  // each position is a pixel
  std::vector<int32_t> first;
  std::vector<T> weights;       // taps x count
  std::vector<bool> symmetric;  // for each position: whether its weights are
  // For each vector of positions:
  std::vector<Runs> runs;
  std::vector<int32_t> starts;  // the first run's first pixel
  // The offset of each run from the first one, as a lane, and a mask that is set if the lane is in the second
  // vector of pixels.
  std::vector<hwy::MakeSigned<T>> from, beyond;

  // The taps of a pixel that the border repeats are merged into one.
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
      for (int64_t k = 0; k < taps / 2; ++k)
        same = same && weights[k * count + i] == weights[(taps - 1 - k) * count + i];
      symmetric.push_back(same);
    }
    copies = taps == 1 && std::all_of(weights.begin(), weights.end(), [](T weight) { return weight == 1; });
  }

  // For along_row.
  void find_runs(int64_t size) {
    from.resize(static_cast<size_t>(count / lanes * lanes));
    beyond.resize(from.size());
    for (int64_t i = 0; i + lanes <= count; i += lanes) {
      starts.push_back(first[i]);
      bool every_second = first[i] + 2 * (lanes - 1) + taps + taps % 2 <= size;
      int32_t furthest = 0;
      bool rising = true;
      for (int64_t k = 0; k < lanes; ++k) {
        const int32_t distance = first[i + k] - first[i];
        from[i + k] = distance % lanes;
        beyond[i + k] = distance < lanes ? 0 : -1;
        every_second = every_second && distance == 2 * k;
        rising = rising && distance >= 0;
        furthest = std::max(furthest, distance);
      }
      const int64_t vectors = furthest / lanes + 1;  // vectors of pixels, from the first run's on
      if (every_second) {
        const bool mirrored =
            std::all_of(symmetric.begin() + i, symmetric.begin() + i + lanes, [](bool same) { return same; });
        runs.push_back(mirrored ? Runs::kMirrored : Runs::kDoubled);
      } else if (rising && vectors <= 2 && first[i] + taps - 1 + vectors * lanes <= size) {
        runs.push_back(vectors == 1 ? Runs::kNear : Runs::kWide);
      } else {
        runs.push_back(Runs::kAny);
      }
    }
  }
};

// The loops over taps are unrolled for kTaps: an even number, 0 for any number, or 1 for an axis that copies.
template <class T, int kTaps>
void along_row(const T* row, const Axis<T>& axis, T* out) {
  using Runs = typename Axis<T>::Runs;
  using V = hn::Vec<Lanes<T>>;
  const Lanes<T> d;
  constexpr int64_t lanes = kLanes<T>;
  const int64_t n = axis.count, taps = kTaps ? kTaps : axis.taps;
  const int32_t *const first = axis.first.data(), *const starts = axis.starts.data();
  const hwy::MakeSigned<T>*const places = axis.from.data(), *const masks = axis.beyond.data();
  const T* const weights = axis.weights.data();
  const Runs* const runs = axis.runs.data();
  int64_t i = 0;
  for (; i + lanes <= n; i += lanes) {
    const auto weighed = [=](V pixels, int64_t k) {
      return kTaps == 1 ? pixels : hn::Mul(pixels, hn::LoadU(d, weights + k * n + i));
    };
    const Runs kind = runs[i / lanes];
    const T* const start = row + starts[i / lanes];
    // With one tap, memory limits the speed: prefetch the next row.
    if (kTaps == 1) hwy::Prefetch(start + first[n - 1]);
    auto sum = hn::Zero(d);
    if (kTaps > 1 && kind == Runs::kMirrored) {
      V pixels[kTaps + 1];
#pragma GCC unroll 8
      for (int64_t k = 0; k < kTaps; k += 2) deinterleave(d, start + k, pixels[k], pixels[k + 1]);
#pragma GCC unroll 8
      for (int64_t k = 0; k < kTaps / 2; ++k)
        sum = hn::Add(sum, weighed(hn::Add(pixels[k], pixels[kTaps - 1 - k]), k));
    } else if (kind == Runs::kMirrored || kind == Runs::kDoubled) {
#pragma GCC unroll 8
      for (int64_t k = 0; k < taps; k += 2) {
        V even, odd;
        deinterleave(d, start + k, even, odd);
        sum = hn::Add(sum, weighed(even, k));
        if (k + 1 < taps) sum = hn::Add(sum, weighed(odd, k + 1));
      }
    } else if (kind == Runs::kNear) {
      const auto from = hn::SetTableIndices(d, places + i);
#pragma GCC unroll 8
      for (int64_t k = 0; k < taps; ++k)
        sum = hn::Add(sum, weighed(hn::TableLookupLanes(hn::LoadU(d, start + k), from), k));
    } else if (kind == Runs::kWide) {
      const auto from = hn::SetTableIndices(d, places + i);
      const auto beyond =
          hn::MaskFromVec(hn::BitCast(d, hn::LoadU(hn::RebindToSigned<Lanes<T>>(), masks + i)));
#pragma GCC unroll 8
      for (int64_t k = 0; k < taps; ++k) {
        const auto low = hn::TableLookupLanes(hn::LoadU(d, start + k), from),
                   high = hn::TableLookupLanes(hn::LoadU(d, start + k + lanes), from);
        sum = hn::Add(sum, weighed(hn::IfThenElse(beyond, high, low), k));
      }
    } else {
#pragma GCC unroll 8
      for (int64_t k = 0; k < taps; ++k) sum = hn::Add(sum, weighed(gathered(d, row + k, first + i), k));
    }
    hn::StoreU(sum, d, out + i);
  }
  for (; i < n; ++i) {
    T sum = 0;
    for (int64_t k = 0; k < taps; ++k) sum += row[first[i] + k] * weights[k * n + i];
    out[i] = sum;
  }
}

// out = the weighted sum of the rows first + k * stride, k < taps, by the weights of position i. Members are
// copied to local variables, because they would be loaded again after every store of a vector.
template <class T, int kTaps>
void down_columns(const T* first, int64_t stride, const Axis<T>& axis, int64_t i, int64_t n, T* out) {
  const int64_t taps = kTaps ? kTaps : axis.taps, count = axis.count;
  const T* const weights = axis.weights.data() + i;
  int64_t done = 0;
  if (kTaps > 1 && axis.symmetric[i]) {
    const Lanes<T> d;
    hn::Vec<Lanes<T>> half[kTaps / 2 + 1];
    for (int64_t k = 0; k < kTaps / 2; ++k) half[k] = hn::Set(d, weights[k * count]);
    for (; done + kLanes<T> <= n; done += kLanes<T>) {
      // Prefetch the rows that the next position adds while these are summed.
      for (int64_t k = 0; k < 2; ++k) hwy::Prefetch(first + (kTaps + k) * stride + done);
      auto sum = hn::Zero(d);
#pragma GCC unroll 8
      for (int64_t k = 0; k < kTaps / 2; ++k)
        sum = hn::Add(sum, hn::Mul(hn::Add(hn::LoadU(d, first + k * stride + done),
                                           hn::LoadU(d, first + (kTaps - 1 - k) * stride + done)),
                                   half[k]));
      hn::StoreU(sum, d, out + done);
    }
  }
  first += done;
  out += done;
  for_lanes<T, 2>(n - done, [=](auto d, auto vectors, int64_t x) {
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    hn::Vec<decltype(d)> sum[vectors];
    for (int v = 0; v < vectors; ++v)
      sum[v] = hn::Mul(hn::LoadU(d, first + x + v * lanes), hn::Set(d, weights[0]));
#pragma GCC unroll 8
    for (int64_t k = 1; k < taps; ++k) {
      const auto weight = hn::Set(d, weights[k * count]);
      for (int v = 0; v < vectors; ++v)
        sum[v] = hn::Add(sum[v], hn::Mul(hn::LoadU(d, first + k * stride + x + v * lanes), weight));
    }
    for (int v = 0; v < vectors; ++v) hn::StoreU(sum[v], d, out + x + v * lanes);
  });
}

// Calls choose with the number of taps for which an axis's loop is unrolled.
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
  const int64_t height = planes.height, width = planes.width, out_height = taps_down.count,
                out_width = taps_across.count;
  const int64_t blocks = (out_height + kRows - 1) / kRows;
  const Axis<T> down(taps_down, height);
  Axis<T> across(taps_across, width);
  across.find_runs(width);
  const auto rows_loop = for_taps(across, [](auto taps) { return &along_row<T, taps.value>; });
  const auto columns_loop = for_taps(down, [](auto taps) { return &down_columns<T, taps.value>; });
  // If the image shrinks, sum rows first, so that fewer rows are resampled. If it grows, resample the rows of
  // a block first, because there are fewer than in the output.
  const bool shrinks = out_height <= height;
  const auto span = [&](int64_t block) {  // the input rows that a block of the output reads
    const auto begin = down.first.begin() + block * kRows,
               end = down.first.begin() + std::min((block + 1) * kRows, out_height);
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
    for (int64_t y = low; !shrinks && y < high; ++y)
      rows_loop(plane + y * width, across, own + (y - low) * out_width);
    for (int64_t y = block * kRows; y < bottom; ++y) {
      if (shrinks) {
        const T* row = plane + down.first[y] * width;
        if (!down.copies) {
          columns_loop(row, width, down, y, width, own);
          row = own;
        }
        rows_loop(row, across, target + y * out_width);
      } else {
        columns_loop(own + (down.first[y] - low) * out_width, out_width, down, y, out_width,
                     target + y * out_width);
      }
    }
  }
}

template void resample(const float*, Planes, const Taps<float>&, const Taps<float>&, float*);
template void resample(const double*, Planes, const Taps<double>&, const Taps<double>&, double*);

template <class T>
void resize(const T* x, Images images, int64_t height, int64_t width, Interpolation mode, bool align_corners,
            bool antialias, T* out) {
  const auto taps = [=](int64_t in, int64_t size) {
    return resize_taps<T>(in, size, mode, align_corners, antialias);
  };
  resample(x, images.planes(), taps(images.height, height), taps(images.width, width), out);
}

template <class T>
void resize_blurred(const T* x, Images images, const T* blur, int64_t length, int64_t height, int64_t width,
                    bool align_corners, Border border, bool before, T* out) {
  const std::vector<T> weights(blur, blur + length);
  const auto taps = [&](int64_t in, int64_t size) {
    const Taps<T> resizing = resize_taps<T>(in, size, Interpolation::kBilinear, align_corners, false);
    return before ? blurred_before(resizing, weights, border, in) : blurred_after(resizing, weights, border);
  };
  resample(x, images.planes(), taps(images.height, height), taps(images.width, width), out);
}

template <class T>
void resampled(const T* x, Images images, const int64_t* rows, int64_t height, int64_t most_down,
               const T* down, const int64_t* columns, int64_t width, int64_t most_across, const T* across,
               T* out) {
  const auto taps = [](const int64_t* index, const T* weights, int64_t count, int64_t each, int64_t size) {
    Taps<T> made(count, each);
    for (int64_t i = 0; i < count * each; ++i)
      made.put(0, i, std::clamp<int64_t>(index[i], 0, size - 1), weights[i]);
    return made;
  };
  resample(x, images.planes(), taps(rows, down, height, most_down, images.height),
           taps(columns, across, width, most_across, images.width), out);
}

CHIASM_INSTANTIATE(resize)
CHIASM_INSTANTIATE(resampled)
CHIASM_INSTANTIATE(resize_blurred)

}  // namespace chiasm::kernels
