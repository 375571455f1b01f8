// Medians of windows: small windows by networks of minima and maxima, large windows of bytes by histograms.
//
// The loops over a row are functions of their own and take values, not references: a store of a vector may
// alias a variable behind a reference, which would be loaded again in every iteration.
#include <array>
#include <utility>

#include "declared/medians.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// Puts the smaller of two values first; `keeps_low` and `keeps_high` tell which results are needed.
struct Exchange {
  int low, high;
  bool swaps, keeps_low, keeps_high;
};

template <int N>
struct Network {
  std::array<Exchange, N * N> steps{};
  int count = 0;
};

// known[i][j]: value i is known not to exceed value j.
template <int N>
using Known = std::array<std::array<bool, N>, N>;

template <int N>
constexpr void exchange(Known<N>& known, int low, int high) {
  const Known<N> before = known;
  for (int i = 0; i < N; ++i) {
    if (i == low || i == high) continue;
    known[i][low] = before[i][low] && before[i][high];
    known[low][i] = before[low][i] || before[high][i];
    known[i][high] = before[i][low] || before[i][high];
    known[high][i] = before[low][i] && before[high][i];
  }
  known[low][high] = true, known[high][low] = false;
}

/** The exchanges that bring the values of the wanted ranks to their places: those of Batcher's odd-even merge
 *  sort (D. Knuth, The Art of Computer Programming, vol. 3, 5.2.2, algorithm M), except those whose outcome
 *  is known beforehand or never used. */
template <int N>
constexpr Network<N> selection(const std::array<bool, N>& wanted, Known<N> known = {}) {
  Network<N> all, kept;
  int top = 1;
  while (top * 2 < N) top *= 2;
  for (int p = top; p > 0; p /= 2) {
    int q = top, r = 0, d = p;
    for (bool more = true; more;) {
      for (int i = 0; i + d < N; ++i)
        if ((i & p) == r && !known[i][i + d]) {
          const bool swaps = known[i + d][i];
          all.steps[all.count++] = {i, i + d, swaps, true, true};
          if (!swaps) {
            exchange<N>(known, i, i + d);
            continue;
          }
          std::swap(known[i], known[i + d]);
          for (auto& row : known) std::swap(row[i], row[i + d]);
        }
      more = q != p;
      if (more) d = q - p, q /= 2, r = p;
    }
  }
  std::array<bool, N> live = wanted;
  for (int k = all.count - 1; k >= 0; --k) {
    Exchange& e = all.steps[k];
    e.keeps_low = live[e.low], e.keeps_high = live[e.high];
    if (e.swaps)
      std::swap(live[e.low], live[e.high]);
    else if (e.keeps_low || e.keeps_high)
      live[e.low] = live[e.high] = true;
  }
  for (int k = 0; k < all.count; ++k)
    if (all.steps[k].keeps_low || all.steps[k].keeps_high) kept.steps[kept.count++] = all.steps[k];
  return kept;
}

template <Exchange e, class V>
HWY_INLINE void exchange(V* values) {
  const V a = values[e.low], b = values[e.high];
  if constexpr (e.swaps) {
    values[e.low] = b, values[e.high] = a;
  } else {
    if constexpr (e.keeps_low) values[e.low] = smaller(a, b);
    if constexpr (e.keeps_high) values[e.high] = larger(a, b);
  }
}

template <const auto& network, class V>
HWY_INLINE void apply(V* values) {
  [=]<int... kStep>(std::integer_sequence<int, kStep...>) { (exchange<network.steps[kStep]>(values), ...); }
  (std::make_integer_sequence<int, network.count>());
}

/** The median of K x K values whose columns are sorted, after J. Paeth, Median finding on a 3 x 3 grid,
 *  Graphics Gems, 1990: if the rows of the sorted columns are then sorted too, entry (i, j) has (i + 1) (j +
 *  1) - 1 others that do not exceed it and (K - i) (K - j) - 1 that are not below it, so few can be the
 *  median. */
template <int K>
struct Square {
  static constexpr int kMedian = K * K / 2;

  static constexpr bool too_low(int i, int j) { return (K - i) * (K - j) - 1 > kMedian; }
  static constexpr bool is_candidate(int i, int j) {
    return !too_low(i, j) && (i + 1) * (j + 1) - 1 <= kMedian;
  }
  static constexpr int count(bool candidates) {
    int n = 0;
    for (int i = 0; i < K; ++i)
      for (int j = 0; j < K; ++j) n += candidates ? is_candidate(i, j) : too_low(i, j);
    return n;
  }
  static constexpr int kCandidates = count(true), kRank = kMedian - count(false);

  // The candidates' places, from the corner with the smallest values on: their partial order is known
  // beforehand.
  static constexpr auto kPlaces = [] {
    std::array<std::array<int, K>, K> places{};
    int n = 0;
    for (int diagonal = 0; diagonal < 2 * K; ++diagonal)
      for (int i = 0; i < K; ++i) {
        const int j = diagonal - i;
        if (j >= 0 && j < K) places[i][j] = is_candidate(i, j) ? n++ : -1;
      }
    return places;
  }();

  static constexpr Network<K> kColumn = [] {
    std::array<bool, K> all{};
    all.fill(true);
    return selection<K>(all);
  }();

  template <int i>
  static constexpr Network<K> kRow = [] {
    std::array<bool, K> wanted{};
    for (int j = 0; j < K; ++j) wanted[j] = is_candidate(i, j);
    return selection<K>(wanted);
  }();

  static constexpr Network<kCandidates> kLast = [] {
    Known<kCandidates> known{};
    for (int i = 0; i < K * K; ++i)
      for (int j = 0; j < K * K; ++j)
        if (i != j && i / K <= j / K && i % K <= j % K && is_candidate(i / K, i % K) &&
            is_candidate(j / K, j % K))
          known[kPlaces[i / K][i % K]][kPlaces[j / K][j % K]] = true;
    std::array<bool, kCandidates> wanted{};
    wanted[kRank] = true;
    return selection<kCandidates>(wanted, known);
  }();

  template <class T>
  static void sort_columns(const std::array<const T*, K>& rows, int64_t n, T* sorted, int64_t length,
                           const T* next) {
    for_lanes_fetching<T, 1, true>(n, next, [=](auto d, auto, int64_t k) {
      hn::Vec<decltype(d)> values[K];
#pragma GCC unroll 8
      for (int i = 0; i < K; ++i) values[i] = hn::LoadU(d, rows[i] + k);
      apply<kColumn>(values);
#pragma GCC unroll 8
      for (int i = 0; i < K; ++i) hn::StoreU(values[i], d, sorted + i * length + k);
    });
  }

  template <int i, class D, class V, class T>
  HWY_INLINE static void add_row(D d, V* candidates, const T* sorted, int64_t step) {
    V values[K];
#pragma GCC unroll 8
    for (int j = 0; j < K; ++j) values[j] = hn::LoadU(d, sorted + (j - K / 2) * step);
    apply<kRow<i>>(values);
#pragma GCC unroll 8
    for (int j = 0; j < K; ++j)
      if (is_candidate(i, j)) candidates[kPlaces[i][j]] = values[j];
  }

  template <class T>
  static void medians_along(const T* sorted, int64_t length, int64_t step, int64_t n, T* out, const T* next) {
    for_lanes_fetching<T, 1, true>(n, next, [=](auto d, auto, int64_t k) {
      hn::Vec<decltype(d)> candidates[kCandidates];
      [&]<int... kRows>(std::integer_sequence<int, kRows...>) {
        (add_row<kRows>(d, candidates, sorted + kRows * length + k, step), ...);
      }
      (std::make_integer_sequence<int, K>());
      apply<kLast>(candidates);
      hn::StoreU(candidates[kRank], d, out + k);
    });
  }
};

template <class V>
HWY_INLINE V median(V a, V b, V c) {
  return larger(smaller(a, b), smaller(larger(a, b), c));
}

// The median of nine is the median of three values: the largest of the columns' minima, the median of their
// medians and the smallest of their maxima. This saves two operations.
template <>
template <class T>
void Square<3>::medians_along(const T* sorted, int64_t length, int64_t step, int64_t n, T* out,
                              const T* next) {
  for_lanes_fetching<T, 1, true>(n, next, [=](auto d, auto, int64_t k) {
    const auto at = [=](int row, int64_t shift) { return hn::LoadU(d, sorted + row * length + k + shift); };
    const auto lowest = larger(larger(at(0, -step), at(0, 0)), at(0, step)),
               highest = smaller(smaller(at(2, -step), at(2, 0)), at(2, step));
    hn::StoreU(median(lowest, median(at(1, -step), at(1, 0), at(1, step)), highest), d, out + k);
  });
}

template <class T, int K>
void medians(const T* x, const Planes& planes, Border border, T* out) {
  const std::vector<T> zeros(static_cast<size_t>(planes.width));
  const int64_t margin = K / 2 * planes.step, lead = whole_lines<T>(margin);
  for_tiles<T>(
      planes, 2 * K + 1, K, lead + margin, border, [&](const Tile& tile, T* scratch, int64_t length) {
        const int64_t plane = tile.plane * planes.height * planes.width;
        const Span span(tile, planes.width, margin, margin);
        T* const sorted = scratch + lead;
        for (int64_t y = tile.top; y < tile.bottom; ++y) {
          std::array<const T*, K> rows;
          for (int i = 0; i < K; ++i) {
            const int64_t source = inside(y + i - K / 2, planes.height, border);
            rows[static_cast<size_t>(i)] =
                source < 0 ? zeros.data() : x + plane + source * planes.width + span.first;
          }
          T* const target = tile_row(out + plane, planes, tile, y);
          Square<K>::sort_columns(rows, span.count(), sorted + span.first - tile.left, length, target);
          for (int i = 0; i < K; ++i)
            extend(sorted + i * length, tile, planes.width, margin, margin, border, T(0), planes.step);
          Square<K>::medians_along(sorted, length, planes.step, tile.right - tile.left, target,
                                   tile_row(x + plane, planes, tile, y + K / 2 + 1));
        }
      });
}

// Histograms of bytes on two levels: one bin for each sixteenth of the range, and one for each value in it.
constexpr int64_t kBins = 16;
using Counts = hn::FixedTag<uint16_t, 8>;

struct Bins {
  hn::Vec<Counts> low = hn::Zero(Counts()), high = hn::Zero(Counts());

  HWY_INLINE void add(const uint16_t* counts) {
    low = hn::Add(low, hn::LoadU(Counts(), counts));
    high = hn::Add(high, hn::LoadU(Counts(), counts + 8));
  }
  HWY_INLINE void subtract(const uint16_t* counts) {
    low = hn::Sub(low, hn::LoadU(Counts(), counts));
    high = hn::Sub(high, hn::LoadU(Counts(), counts + 8));
  }

  /** The bin of the value of this rank. Subtracts the counts of the bins below it from the rank. */
  HWY_INLINE int64_t find(int64_t& rank) const {
    const Counts d;
    const auto sums = [=](auto v) {
      v = hn::Add(v, hn::ShiftLeftLanes<1>(d, v));
      v = hn::Add(v, hn::ShiftLeftLanes<2>(d, v));
      return hn::Add(v, hn::ShiftLeftLanes<4>(d, v));
    };
    const auto first = sums(low), second = hn::Add(sums(high), hn::Broadcast<7>(first));
    const auto most = hn::Set(d, static_cast<uint16_t>(rank));
    const auto below = [=](auto v) {
      return static_cast<int64_t>(hn::CountTrue(d, hn::Eq(hn::SaturatedSub(v, most), hn::Zero(d))));
    };
    alignas(16) uint16_t upto[8 + kBins];
    hn::Store(hn::Zero(d), d, upto);
    hn::Store(first, d, upto + 8);
    hn::Store(second, d, upto + 16);
    const int64_t bin = below(first) + below(second);
    rank -= upto[7 + bin];
    return bin;
  }
};

/** Histograms of columns of ky pixels. */
class ColumnHistograms {
 public:
  // Bytes for a column.
  static constexpr int64_t kBytes = (kBins + kBins * kBins) * int64_t{sizeof(uint16_t)};

  ColumnHistograms(uint8_t* memory, int64_t columns)
      : coarse_(reinterpret_cast<uint16_t*>(memory)), fine_(coarse_ + columns * kBins), columns_(columns) {
    std::fill_n(memory, columns * kBytes, uint8_t{0});
  }

  void add(const uint8_t* row) const { count(row, 1); }
  void subtract(const uint8_t* row) const { count(row, -1); }

  /** The values of a rank in the windows that begin at each of n pixels of a channel: S. Perreault, P.
   *  Hebert, Median filtering in constant time, IEEE TIP 16(9), 2007. A window's histogram is its
   *  neighbour's, plus one column and minus one. The fine bins of a sixteenth are updated only when they are
   *  needed. */
  void select(int64_t channel, int64_t n, int64_t step, int64_t kx, int64_t rank, uint8_t* out) const {
    const uint16_t* const coarse = coarse_ + channel * kBins;
    const int64_t next = step * kBins;  // column
    Bins window, parts[kBins];
    int64_t begins[kBins];
    std::fill_n(begins, kBins, -kx);
    for (int64_t j = 0; j < kx; ++j) window.add(coarse + j * next);
    for (int64_t i = 0; i < n; ++i) {
      if (i > 0) {
        window.add(coarse + (i + kx - 1) * next);
        window.subtract(coarse + (i - 1) * next);
      }
      int64_t left = rank;
      const int64_t bin = window.find(left);
      const uint16_t* const fine = fine_ + (bin * columns_ + channel) * kBins;
      Bins part = parts[bin];
      int64_t begin = begins[bin];
      if (2 * (i - begin) >= kx) {
        part = Bins();
        for (int64_t j = i; j < i + kx; ++j) part.add(fine + j * next);
      } else {
        for (; begin < i; ++begin) {
          part.add(fine + (begin + kx) * next);
          part.subtract(fine + begin * next);
        }
      }
      parts[bin] = part, begins[bin] = i;
      const int64_t value = part.find(left);
      out[i * step] = static_cast<uint8_t>(bin * kBins + value);
    }
  }

 private:
  void count(const uint8_t* row, int by) const {
    for (int64_t k = 0; k < columns_; ++k) {
      const int64_t bin = row[k] / kBins;
      coarse_[k * kBins + bin] = static_cast<uint16_t>(coarse_[k * kBins + bin] + by);
      uint16_t& fine = fine_[(bin * columns_ + k) * kBins + row[k] % kBins];
      fine = static_cast<uint16_t>(fine + by);
    }
  }

  uint16_t* const coarse_;
  uint16_t* const fine_;
  const int64_t columns_;
};

}  // namespace

template <class P>
void median_filter(const P* x, int64_t n, int64_t h, int64_t l, int64_t step, int64_t size, Border border,
                   P* out) {
  const Planes planes{n, h, l, step};
  if (size == 3) return medians<P, 3>(x, planes, border, out);
  if (size == 5) return medians<P, 5>(x, planes, border, out);
  medians<P, 7>(x, planes, border, out);
}

void rank_of_bytes(const uint8_t* x, int64_t n, int64_t h, int64_t l, int64_t step, int64_t ky, int64_t kx,
                   int64_t rank, Border border, uint8_t* out) {
  const Planes planes{n, h, l, step};
  // A ring with one row more than the window: the row that has just left it.
  const int64_t rows = ky + 1, ends = PaddedRows<uint8_t>::ends(planes, kx, kx / 2);
  // Strips whose histograms fit into L2, but not narrower than 5 times the ends that strips read twice.
  const int64_t columns = std::max<int64_t>(512, 5 * ends);
  for_tiles<uint8_t>(
      planes, 262144 / columns, rows + ColumnHistograms::kBytes, ends, border,
      [&](const Tile& tile, uint8_t* ring, int64_t length) {
        const int64_t plane = tile.plane * h * l, width = tile.right - tile.left;
        const PaddedRows<uint8_t> padded(x + plane, planes, tile, border, 0, rows, kx, ky / 2 + 1, kx / 2,
                                         ring, length);
        const ColumnHistograms histograms(ring + rows * length, width + (kx - 1) * step);
        for (int64_t i = 1; i < ky; ++i) histograms.add(padded.at(tile.top, i, 0));
        for (int64_t y = tile.top; y < tile.bottom; ++y) {
          uint8_t* const target = tile_row(out + plane, planes, tile, y);
          padded.advance(y, target);
          histograms.add(padded.at(y, ky, 0));
          if (y > tile.top) histograms.subtract(padded.at(y, 0, 0));
          for (int64_t c = 0; c < step; ++c) histograms.select(c, width / step, step, kx, rank, target + c);
        }
      },
      std::max(kTileRows, 4 * ky));
}

CHIASM_INSTANTIATE(median_filter)

}  // namespace chiasm::kernels
