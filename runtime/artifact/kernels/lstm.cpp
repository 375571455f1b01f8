// Long short-term memory: what a layer computes from step to step (S. Hochreiter, J. Schmidhuber, Neural
// Computation 9(8), 1997; with the forget gate of F. Gers, J. Schmidhuber, F. Cummins, 2000).
#include <algorithm>
#include <vector>

#include "declared/lstm.h"
#include "functions.h"
#include "lanes.h"
#include "products.h"

namespace chiasm::kernels {
namespace {

template <class V>
HWY_INLINE V sigmoid(V v) {
  const hn::DFromV<V> d;
  const V one = hn::Set(d, hn::TFromV<V>(1));
  const V power = vector_exp(hn::Neg(hn::Abs(v)));  // of no large number, which would overflow
  const V positive = hn::Div(one, hn::Add(one, power));
  return hn::IfThenElse(hn::Lt(v, hn::Zero(d)), hn::Mul(power, positive), positive);
}

template <class V>
HWY_INLINE V hyperbolic_tangent(V v) {
  return hn::IfThenElse(hn::IsNaN(v), v, hn::CallTanh(hn::DFromV<V>(), v));
}

/** out = added + the products of kRows rows of `depth` values with the columns of kPanels panels. Rows of
 *  `added` and `out` have `g` values, of which `there` belong to these panels.
 *
 *  A step has as few rows as the batch, often one: fewer than a tile of products.h. */
template <int64_t kRows, int64_t kPanels, class T>
void multiply_rows(const T* rows, int64_t depth, const T* panel, const T* added, int64_t g, int64_t there,
                   T* out) {
  constexpr int64_t lanes = kLanes<T>, vectors = kPanels * kPanel / lanes;
  const Lanes<T> d;
  hn::Vec<Lanes<T>> sums[kRows][vectors];
  for (auto& row : sums)
    for (auto& sum : row) sum = hn::Zero(d);
  for (int64_t k = 0; k < depth; ++k)
    for (int64_t v = 0; v < vectors; ++v) {
      const int64_t column = v * lanes;
      const auto factor = hn::LoadU(d, panel + (column / kPanel * depth + k) * kPanel + column % kPanel);
      for (int64_t r = 0; r < kRows; ++r)
        sums[r][v] = hn::MulAdd(hn::Set(d, rows[r * depth + k]), factor, sums[r][v]);
    }
  for (int64_t r = 0; r < kRows; ++r) {
    T all[kPanels * kPanel];
    for (int64_t v = 0; v < vectors; ++v) hn::StoreU(sums[r][v], d, all + v * lanes);
    for (int64_t n = 0; n < there; ++n) out[r * g + n] = added[r * g + n] + all[n];
  }
}

constexpr int64_t kRows = 4, kPanels = 4;

}  // namespace

template <class T>
void lstm(const T* gates, int64_t l, int64_t b, int64_t g, const T* weight, int64_t p, int64_t h,
          const T* hidden, const T* cell, bool reverse, T* out) {
  constexpr int64_t kWork = 1 << 15;  // multiplications that are worth another thread
  std::vector<T> all_sums(static_cast<size_t>(b * g));
  T* const sums = all_sums.data();
  const int64_t chunks = (p + kPanels - 1) / kPanels, blocks = (b + kRows - 1) / kRows;
#pragma omp parallel if (b * g * h > kWork)
  for (int64_t step = 0; step < l; ++step) {
    const int64_t t = reverse ? l - 1 - step : step, before = reverse ? t + 1 : t - 1;
    const T* const last_hidden = step == 0 ? hidden : out + before * b * h;
    const T* const last_cell = step == 0 ? cell : out + (l + before) * b * h;
#pragma omp for
    for (int64_t task = 0; task < blocks * chunks; ++task) {
      const int64_t row = task / chunks * kRows, panel = task % chunks * kPanels;
      const auto multiply_panel = [&](auto rows, auto panels, int64_t r, int64_t k) {
        const int64_t at = r * g + k * kPanel;
        multiply_rows<rows, panels>(last_hidden + r * h, h, weight + k * h * kPanel, gates + t * b * g + at,
                                    g, std::min(panels * kPanel, g - k * kPanel), sums + at);
      };
      constexpr std::integral_constant<int64_t, 1> one;
      constexpr std::integral_constant<int64_t, 4> four;
      const int64_t end_row = std::min(row + kRows, b), end_panel = std::min(panel + kPanels, p);
      if (end_row - row == kRows)
        for (int64_t k = panel; k < end_panel; ++k) multiply_panel(four, one, row, k);
      else if (end_panel - panel == kPanels)
        for (int64_t r = row; r < end_row; ++r) multiply_panel(one, four, r, panel);
      else
        for (int64_t r = row; r < end_row; ++r)
          for (int64_t k = panel; k < end_panel; ++k) multiply_panel(one, one, r, k);
    }
#pragma omp for
    for (int64_t row = 0; row < b; ++row) {
      const T* const from = sums + row * g;
      const T* const memory = last_cell + row * h;
      T* const to = out + (t * b + row) * h;
      T* const next_memory = out + ((l + t) * b + row) * h;
      for_lanes<T>(h, [=](auto d, auto, int64_t k) {
        const auto gate = [=](int64_t i) { return hn::LoadU(d, from + i * h + k); };
        const auto kept = hn::Mul(sigmoid(gate(1)), hn::LoadU(d, memory + k));
        const auto next = hn::Add(kept, hn::Mul(sigmoid(gate(0)), hyperbolic_tangent(gate(2))));
        const auto result = hn::Mul(sigmoid(gate(3)), hyperbolic_tangent(next));
        hn::StoreU(next, d, next_memory + k);
        hn::StoreU(result, d, to + k);
      });
    }
  }
}

CHIASM_INSTANTIATE(lstm)

}  // namespace chiasm::kernels
