// Where the extreme values of rows are, and sums of bytes and of their squares.
#include <limits>
#include <type_traits>

#include "rows.h"

namespace chiasm::kernels {
namespace {

// The least or the greatest of n values, infinity if all of them are NaN. NaN is ignored.
template <bool greatest, class P>
P extreme(const P* x, int64_t n) {
  using Limits = std::numeric_limits<P>;
  P result = greatest ? Limits::lowest() : Limits::max();
  if constexpr (std::is_floating_point_v<P>) result = greatest ? -Limits::infinity() : Limits::infinity();
  const Lanes<P> d;
  // the second argument if one is NaN
  const auto better = [](auto v, auto best) {
    if constexpr (greatest)
      return larger(v, best);
    else
      return smaller(v, best);
  };
  constexpr int64_t kBests = 4;
  hn::Vec<Lanes<P>> best[kBests];
  for (auto& v : best) v = hn::Set(d, result);
  int64_t k = 0;
  for (; k + kBests * kLanes<P> <= n; k += kBests * kLanes<P>)
    for (int64_t v = 0; v < kBests; ++v) best[v] = better(hn::LoadU(d, x + k + v * kLanes<P>), best[v]);
  for (; k + kLanes<P> <= n; k += kLanes<P>) best[0] = better(hn::LoadU(d, x + k), best[0]);
  const auto take = [&](P v) {
    if (greatest ? v > result : v < result) result = v;
  };
  for (const auto& v : best) {
    P lanes[kLanes<P>];
    hn::StoreU(v, d, lanes);
    for (const P lane : lanes) take(lane);
  }
  for (; k < n; ++k) take(x[k]);
  return result;
}

// The first of n values that equals `value`, or 0.
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
  return 0;
}

}  // namespace

template <class P>
void extreme_index(const P* x, int64_t n, int64_t length, bool greatest, int64_t* out) {
#pragma omp parallel for
  for (int64_t i = 0; i < n; ++i) {
    const P* const row = x + i * length;
    out[i] = first_equal(row, length, greatest ? extreme<true>(row, length) : extreme<false>(row, length));
  }
}

void moments_bytes(const uint8_t* x, int64_t n, int64_t length, int64_t* out) {
  const Lanes<int16_t> words;
  const Lanes<int32_t> sums;
  constexpr int64_t kBlock = 8192;  // vectors; 2 * 255^2 for each fit in 32 bits
#pragma omp parallel for
  for (int64_t i = 0; i < n; ++i) {
    const uint8_t* const row = x + i * length;
    int64_t sum = 0, squares = 0, k = 0;
    while (k + kLanes<int16_t> <= length) {
      hn::Vec<decltype(sums)> of_values[2] = {hn::Zero(sums), hn::Zero(sums)},
                              of_squares[2] = {hn::Zero(sums), hn::Zero(sums)};
      for (int64_t v = 0; v < kBlock && k + kLanes<int16_t> <= length; ++v, k += kLanes<int16_t>) {
        const auto values = hn::PromoteTo(words, hn::LoadU(hn::Rebind<uint8_t, Lanes<int16_t>>(), row + k));
        of_values[0] = hn::ReorderWidenMulAccumulate(sums, values, hn::Set(words, int16_t{1}), of_values[0],
                                                     of_values[1]);
        of_squares[0] = hn::ReorderWidenMulAccumulate(sums, values, values, of_squares[0], of_squares[1]);
      }
      int32_t lanes[2][kLanes<int32_t>];
      hn::StoreU(hn::Add(of_values[0], of_values[1]), sums, lanes[0]);
      hn::StoreU(hn::Add(of_squares[0], of_squares[1]), sums, lanes[1]);
      for (int64_t v = 0; v < kLanes<int32_t>; ++v) sum += lanes[0][v], squares += lanes[1][v];
    }
    for (; k < length; ++k) sum += row[k], squares += int64_t{row[k]} * row[k];
    out[2 * i] = sum;
    out[2 * i + 1] = squares;
  }
}

CHIASM_INSTANTIATE(extreme_index)

}  // namespace chiasm::kernels
