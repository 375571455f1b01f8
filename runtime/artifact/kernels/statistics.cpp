// Where the extreme values of channels are, and sums of bytes and of their squares.
#include <omp.h>

#include <limits>
#include <type_traits>
#include <vector>

#include "declared/statistics.h"
#include "interleaving.h"

namespace chiasm::kernels {
namespace {

// Calls body(place, values, count, first) for runs of `count` pixels of a row, the first of which is pixel
// `first`. Rows are divided among threads: all runs of a place, i.e. of `strips` in each row, are in one thread,
// in their order. A run has at most kPart values, or is one pixel.
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

// Widens `least` and `greatest` to those of n values; NaN is ignored. Says whether a value was outside of them,
// which is rare after the first parts of an image: only then are the lanes compared with each other.
template <class P>
bool widen(const P* x, int64_t n, P& least, P& greatest) {
  const Lanes<P> d;
  constexpr int64_t kVectors = 4;
  const auto from = hn::Set(d, least), to = hn::Set(d, greatest);
  hn::Vec<Lanes<P>> low[kVectors], high[kVectors];
  std::fill_n(low, kVectors, from);
  std::fill_n(high, kVectors, to);
  const auto take = [&](int64_t v, const P* p) {
    const auto values = hn::LoadU(d, p);
    // the second argument if one is NaN
    low[v] = smaller(values, low[v]);
    high[v] = larger(values, high[v]);
  };
  int64_t k = 0;
  for (; k + kVectors * kLanes<P> <= n; k += kVectors * kLanes<P>)
    for (int64_t v = 0; v < kVectors; ++v) take(v, x + k + v * kLanes<P>);
  for (; k + kLanes<P> <= n; k += kLanes<P>) take(0, x + k);
  P last[kLanes<P>];
  if (k < n && n >= kLanes<P>) {
    take(0, x + n - kLanes<P>);
  } else if (k < n) {
    std::fill(std::copy(x, x + n, last), last + kLanes<P>, x[0]);
    take(0, last);
  }
  for (int64_t v = 1; v < kVectors; ++v) {
    low[0] = hn::Min(low[0], low[v]);
    high[0] = hn::Max(high[0], high[v]);
  }
  if (hn::AllTrue(d, hn::And(hn::Eq(low[0], from), hn::Eq(high[0], to)))) return false;
  P lanes[2][kLanes<P>];
  hn::StoreU(low[0], d, lanes[0]);
  hn::StoreU(high[0], d, lanes[1]);
  least = *std::min_element(lanes[0], lanes[0] + kLanes<P>);
  greatest = *std::max_element(lanes[1], lanes[1] + kLanes<P>);
  return true;
}

// The first of n values that equals `value`, or -1.
template <class P>
int64_t first_equal(const P* x, int64_t n, P value) {
  const Lanes<P> d;
  int64_t k = 0;
  for (; k + kLanes<P> <= n; k += kLanes<P>) {
    const intptr_t lane = hn::FindFirstTrue(d, hn::Eq(hn::LoadU(d, x + k), hn::Set(d, value)));
    if (lane >= 0) return k + lane;
  }
  for (; k < n; ++k)
    if (x[k] == value) return k;
  return -1;
}

// An extreme value and its first index; -1 if there is none.
template <class P>
struct Extreme {
  P value;
  int64_t index = -1;
};

// The least and the greatest value of a channel.
template <class P>
struct Range {
  using Limits = std::numeric_limits<P>;
  static constexpr bool is_float = std::is_floating_point_v<P>;
  Extreme<P> least{is_float ? Limits::infinity() : Limits::max()};
  Extreme<P> greatest{is_float ? -Limits::infinity() : Limits::lowest()};

  // Takes n values that come after all that it has; the first of them is at index `first`.
  void take(const P* x, int64_t n, int64_t first) {
    P low = least.value, high = greatest.value;
    // a value may be one of the two that stand for none
    if (!widen(x, n, low, high) && least.index >= 0 && greatest.index >= 0) return;
    const auto update = [&](Extreme<P>& extreme, P value) {
      if (extreme.index >= 0 && value == extreme.value) return;
      const int64_t index = first_equal(x, n, value);
      if (index >= 0) extreme = {value, first + index};
    };
    update(least, low);
    update(greatest, high);
  }

  // Takes the range of values that come after all that it has.
  void take(const Range& later) {
    if (later.least.index >= 0 && (least.index < 0 || later.least.value < least.value)) least = later.least;
    if (later.greatest.index >= 0 && (greatest.index < 0 || later.greatest.value > greatest.value))
      greatest = later.greatest;
  }
};

// The ranges of the channels of pixels.
template <class P>
class Ranges {
 public:
  explicit Ranges(int64_t step) : step_(step), ranges_(static_cast<size_t>(step)) {
    if (step < 2 || step > 4) return;
    for (auto& limits : limits_) limits.resize(ranges_.size() * kLanes<P>);
  }

  // Takes n pixels that come after all that it has; the first of them is pixel `first`.
  void take(const P* x, int64_t n, int64_t first) {
    if (has_all(x, n)) return;
    for_channels(x, n, step_, [&](int64_t c, const P* values) { ranges_[size_t(c)].take(values, n, first); });
    for (size_t k = 0; k < limits_[0].size(); ++k) {
      limits_[0][k] = ranges_[k % ranges_.size()].least.value;
      limits_[1][k] = ranges_[k % ranges_.size()].greatest.value;
    }
    complete_ = std::all_of(ranges_.begin(), ranges_.end(), [](const Range<P>& range) {
      return range.least.index >= 0 && range.greatest.index >= 0;
    });
  }

  const Range<P>& operator[](int64_t channel) const { return ranges_[static_cast<size_t>(channel)]; }

 private:
  // Whether no value is outside of its channel's range: true for nearly all runs of an image. To find that out,
  // pixels need not be split into channels.
  bool has_all(const P* x, int64_t n) const {
    if (!complete_ || n < kLanes<P>) return false;
    return (step_ == 2 && has_all_of<2>(x, n)) || (step_ == 3 && has_all_of<3>(x, n)) ||
           (step_ == 4 && has_all_of<4>(x, n));
  }

  template <int kStep>
  bool has_all_of(const P* x, int64_t n) const {
    const Lanes<P> d;
    hn::Vec<Lanes<P>> limits[2][kStep], low[kStep], high[kStep];
    for (int64_t v = 0; v < kStep; ++v) {
      low[v] = limits[0][v] = hn::LoadU(d, limits_[0].data() + v * kLanes<P>);
      high[v] = limits[1][v] = hn::LoadU(d, limits_[1].data() + v * kLanes<P>);
    }
    for (int64_t k = 0; k < n; k += kLanes<P>) {
      const P* const pixels = x + std::min(k, n - kLanes<P>) * kStep;
      for (int64_t v = 0; v < kStep; ++v) {
        const auto values = hn::LoadU(d, pixels + v * kLanes<P>);
        // the second argument if one is NaN
        low[v] = smaller(values, low[v]);
        high[v] = larger(values, high[v]);
      }
    }
    auto same = hn::Eq(low[0], limits[0][0]);
    for (int64_t v = 0; v < kStep; ++v) {
      same = hn::And(same, hn::Eq(low[v], limits[0][v]));
      same = hn::And(same, hn::Eq(high[v], limits[1][v]));
    }
    return hn::AllTrue(d, same);
  }

  int64_t step_;
  std::vector<Range<P>> ranges_;
  bool complete_ = false;  // each range has a value
  // The least and the greatest values of the channels of as many pixels as a vector has lanes
  std::vector<P> limits_[2];
};

}  // namespace

template <class P>
void extreme_indices(const P* x, int64_t n, int64_t length, int64_t step, int64_t* out) {
  const int64_t strips = strips_of(n, length / step);
  std::vector<Ranges<P>> found(static_cast<size_t>(n * strips), Ranges<P>(step));
  for_runs(x, n, length, step, strips, [&](int64_t place, const P* values, int64_t count, int64_t first) {
    found[static_cast<size_t>(place)].take(values, count, first);
  });
  for (int64_t i = 0; i < n * step; ++i) {
    Range<P> range;
    for (int64_t strip = 0; strip < strips; ++strip)
      range.take(found[static_cast<size_t>(i / step * strips + strip)][i % step]);
    out[2 * i] = std::max<int64_t>(range.least.index, 0);
    out[2 * i + 1] = std::max<int64_t>(range.greatest.index, 0);
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
