// Where the extreme values of channels are, and sums of bytes and of their squares.
#include <omp.h>

#include <limits>
#include <type_traits>
#include <vector>

#include "declared/statistics.h"
#include "interleaving.h"

namespace chiasm::kernels {
namespace {

// Divides each row into `strips` parts, the places, and calls body(place, values, count, first) for runs of
// `count` pixels from pixel `first` of the row on. Places are divided among threads: one thread does all runs
// of a place, in their order. A run has at most kPart values, or is one pixel.
template <class P, class Body>
void for_runs(const P* x, int64_t n, int64_t length, int64_t step, int64_t strips, const Body& body) {
  const int64_t pixels = length / step;
#pragma omp parallel for
  for (int64_t place = 0; place < n * strips; ++place) {
    const P* const row = x + place / strips * length;
    const int64_t strip = place % strips, begin = pixels * strip / strips,
                  end = pixels * (strip + 1) / strips;
    const int64_t most = std::max<int64_t>(kPart / step, 1);
    for (int64_t first = begin; first < end; first += most)
      body(place, row + first * step, std::min(most, end - first), first);
  }
}

// Calls body(channel, values) with the values of each channel of a run.
template <class P, class Body>
void for_channels(const P* values, int64_t count, int64_t step, const Body& body) {
  P apart[kPart];
  if (step > 1 && step <= kPart) {
    split_channels(values, count, step, count, apart);
    values = apart;
  }  // else a run is one pixel, or of one channel
  for (int64_t c = 0; c < step; ++c) body(c, values + c * count);
}

// As many as there are threads, unless there are enough rows.
int64_t strips_of(int64_t n, int64_t pixels) {
  return n >= omp_get_max_threads() ? 1 : std::clamp<int64_t>(pixels / kPart, 1, omp_get_max_threads());
}

// An extreme value of a channel, and the first pixel of the first run that has it.
template <class P>
struct Extreme {
  P value;
  int64_t run = 0;

  // The first pixel, from the run's first one up to `end`, that has the value; -1 if there is none. `channel`
  // points at the channel's value of pixel 0.
  int64_t pixel(const P* channel, int64_t step, int64_t end) const {
    for (int64_t k = run; k < end; ++k)
      if (channel[k * step] == value) return k;
    return -1;
  }
};

// Minimum and maximum of each channel, 1 to 4 channels. NaN is ignored.
template <class P>
class Extremes {
 public:
  explicit Extremes(int64_t step) : step_(step) {
    using Limits = std::numeric_limits<P>;
    constexpr bool is_float = std::is_floating_point_v<P>;
    std::fill_n(extremes_[0], step, Extreme<P>{is_float ? Limits::infinity() : Limits::max()});
    std::fill_n(extremes_[1], step, Extreme<P>{is_float ? -Limits::infinity() : Limits::lowest()});
    repeat();
  }

  // Takes a run of n values that come after all that it has. Pixels are not split into channels: a block of
  // vectors is a whole number of pixels, so each of its lanes has one channel.
  void take(const P* x, int64_t n, int64_t run) {
    step_ == 3 ? take_of<3>(x, n, run) : take_of<4>(x, n, run);
  }

  // The least value of a channel, or the greatest.
  const Extreme<P>& get(bool greatest, int64_t channel) const { return extremes_[greatest][channel]; }

 private:
  template <int kVectors>
  void take_of(const P* x, int64_t n, int64_t run) {
    const Lanes<P> d;
    constexpr int64_t kBlock = kVectors * kLanes<P>;
    P block[2][kBlock];
    if (n < kBlock) {
      for (int64_t k = 0; k < kBlock; ++k) block[0][k] = x[k % n];
      x = block[0];
      n = kBlock;
    }
    hn::Vec<Lanes<P>> limits[2][kVectors], low[kVectors], high[kVectors];
    for (int64_t v = 0; v < kVectors; ++v) {
      low[v] = limits[0][v] = hn::LoadU(d, limits_[0] + v * kLanes<P>);
      high[v] = limits[1][v] = hn::LoadU(d, limits_[1] + v * kLanes<P>);
    }
    for (int64_t k = 0; k < n; k += kBlock) {
      const P* const from = x + std::min(k, n - kBlock);
      for (int64_t v = 0; v < kVectors; ++v) {
        const auto values = hn::LoadU(d, from + v * kLanes<P>);
        // the second argument if one is NaN
        low[v] = smaller(values, low[v]);
        high[v] = larger(values, high[v]);
      }
    }
    auto same = hn::Eq(low[0], limits[0][0]);
    for (int64_t v = 0; v < kVectors; ++v) {
      same = hn::And(same, hn::Eq(low[v], limits[0][v]));
      same = hn::And(same, hn::Eq(high[v], limits[1][v]));
    }
    // Nearly all runs of an image have no new extreme.
    if (hn::AllTrue(d, same)) return;
    for (int64_t v = 0; v < kVectors; ++v) {
      hn::StoreU(low[v], d, block[0] + v * kLanes<P>);
      hn::StoreU(high[v], d, block[1] + v * kLanes<P>);
    }
    for (int64_t k = 0, c = 0; k < kBlock; ++k, c = c + 1 == step_ ? 0 : c + 1) {
      if (block[0][k] < extremes_[0][c].value) extremes_[0][c] = {block[0][k], run};
      if (block[1][k] > extremes_[1][c].value) extremes_[1][c] = {block[1][k], run};
    }
    repeat();
  }

  void repeat() {
    for (int64_t k = 0, c = 0; k < 4 * kLanes<P>; ++k, c = c + 1 == step_ ? 0 : c + 1) {
      limits_[0][k] = extremes_[0][c].value;
      limits_[1][k] = extremes_[1][c].value;
    }
  }

  int64_t step_;
  Extreme<P> extremes_[2][4];   // the least and the greatest value of each channel
  P limits_[2][4 * kLanes<P>];  // their values, for the lanes of a block
};

}  // namespace

template <class P>
void extreme_indices(const P* x, int64_t n, int64_t length, int64_t step, int64_t* out) {
  const int64_t pixels = length / step, strips = strips_of(n, pixels);
  // Of more than four channels each is taken alone.
  const int64_t together = step <= 4 ? step : 1, parts = step / together;
  std::vector<Extremes<P>> found(static_cast<size_t>(n * strips * parts), Extremes<P>(together));
  for_runs(x, n, length, step, strips, [&](int64_t place, const P* values, int64_t count, int64_t first) {
    Extremes<P>* const here = found.data() + place * parts;
    if (parts == 1) return here->take(values, count * step, first);
    for_channels(values, count, step,
                 [&](int64_t c, const P* channel) { here[c].take(channel, count, first); });
  });
  for (int64_t i = 0; i < n * step; ++i) {
    const int64_t row = i / step, c = i % step;
    const P* const channel = x + row * length + c;
    for (const bool greatest : {false, true}) {
      P best{};
      int64_t at = -1;
      for (int64_t strip = 0; strip < strips; ++strip) {
        const auto& extremes = found[static_cast<size_t>((row * strips + strip) * parts + c / together)];
        const Extreme<P>& extreme = extremes.get(greatest, c % together);
        if (at >= 0 && !(greatest ? extreme.value > best : extreme.value < best)) continue;
        const int64_t pixel = extreme.pixel(channel, step, pixels * (strip + 1) / strips);
        if (pixel < 0) continue;
        best = extreme.value;
        at = pixel;
      }
      out[2 * i + greatest] = std::max<int64_t>(at, 0);
    }
  }
}

namespace {

// Adds the sum and the sum of squares of n values.
void add_moments(const uint8_t* x, int64_t n, int64_t* moments) {
  const Lanes<int16_t> words;
  const Lanes<int32_t> sums;
  constexpr int64_t kBlock = 8192;  // vectors; 2 * 255^2 for each fit in 32 bits
  int64_t k = 0;
  while (k + kLanes<int16_t> <= n) {
    hn::Vec<decltype(sums)> of_values[2] = {hn::Zero(sums), hn::Zero(sums)},
                            of_squares[2] = {hn::Zero(sums), hn::Zero(sums)};
    for (int64_t v = 0; v < kBlock && k + kLanes<int16_t> <= n; ++v, k += kLanes<int16_t>) {
      const auto values = hn::PromoteTo(words, hn::LoadU(hn::Rebind<uint8_t, Lanes<int16_t>>(), x + k));
      of_values[0] =
          hn::ReorderWidenMulAccumulate(sums, values, hn::Set(words, int16_t{1}), of_values[0], of_values[1]);
      of_squares[0] = hn::ReorderWidenMulAccumulate(sums, values, values, of_squares[0], of_squares[1]);
    }
    int32_t lanes[2][kLanes<int32_t>];
    hn::StoreU(hn::Add(of_values[0], of_values[1]), sums, lanes[0]);
    hn::StoreU(hn::Add(of_squares[0], of_squares[1]), sums, lanes[1]);
    for (int64_t v = 0; v < kLanes<int32_t>; ++v) moments[0] += lanes[0][v], moments[1] += lanes[1][v];
  }
  for (; k < n; ++k) moments[0] += x[k], moments[1] += int64_t{x[k]} * x[k];
}

}  // namespace

void moments_bytes(const uint8_t* x, int64_t n, int64_t length, int64_t step, int64_t* out) {
  const int64_t strips = strips_of(n, length / step);
  std::vector<int64_t> moments(static_cast<size_t>(2 * n * strips * step));
  for_runs(x, n, length, step, strips, [&](int64_t place, const uint8_t* values, int64_t count, int64_t) {
    for_channels(values, count, step, [&](int64_t channel, const uint8_t* of_channel) {
      add_moments(of_channel, count, moments.data() + 2 * (place * step + channel));
    });
  });
  for (int64_t i = 0; i < 2 * n * step; ++i) {
    out[i] = 0;
    for (int64_t strip = 0; strip < strips; ++strip)
      out[i] += moments[static_cast<size_t>((i / (2 * step) * strips + strip) * 2 * step + i % (2 * step))];
  }
}

CHIASM_INSTANTIATE(extreme_indices)

}  // namespace chiasm::kernels
