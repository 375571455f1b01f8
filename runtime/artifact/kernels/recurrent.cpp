// What recurrent layers compute from step to step: long short-term memory (S. Hochreiter and J. Schmidhuber,
// Neural Computation 9(8), 1997; the forget gate is of F. Gers et al., 2000), and gated recurrent units
// (K. Cho et al., arXiv:1406.1078, 2014), whose reset gate acts on the product, as PyTorch's.
#include <algorithm>
#include <vector>

#include "declared/recurrent.h"
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

/** The weights of a hidden state: panels of kPanel outputs, `outputs` in all. */
template <class T>
struct Weights {
  const T* panels;
  int64_t count, depth, outputs;
};

/** Numbers that are added to products: `row` is how far it is from one sample's to the next's. */
template <class T>
struct Added {
  const T* data;
  int64_t row;
};

/** out = added + the products of kRows rows with the columns of kPanels panels.
 *
 *  A step has as few rows as the batch, often one: fewer than a tile of products.h. */
template <int64_t kRows, int64_t kPanels, class T>
void multiply_rows(const T* rows, const Weights<T>& weights, int64_t panel, Added<T> added, T* out) {
  constexpr int64_t lanes = kLanes<T>, vectors = kPanels * kPanel / lanes;
  const Lanes<T> d;
  const int64_t depth = weights.depth, first = panel * kPanel,
                there = std::min(kPanels * kPanel, weights.outputs - first);
  const T* const factors = weights.panels + first * depth;
  hn::Vec<Lanes<T>> sums[kRows][vectors];
  for (auto& row : sums)
    for (auto& sum : row) sum = hn::Zero(d);
  for (int64_t k = 0; k < depth; ++k)
    for (int64_t v = 0; v < vectors; ++v) {
      const int64_t column = v * lanes;
      const auto factor = hn::LoadU(d, factors + (column / kPanel * depth + k) * kPanel + column % kPanel);
      for (int64_t r = 0; r < kRows; ++r)
        sums[r][v] = hn::MulAdd(hn::Set(d, rows[r * depth + k]), factor, sums[r][v]);
    }
  for (int64_t r = 0; r < kRows; ++r) {
    T all[kPanels * kPanel];
    for (int64_t v = 0; v < vectors; ++v) hn::StoreU(sums[r][v], d, all + v * lanes);
    const T* const more = added.data + r * added.row + first;
    for (int64_t n = 0; n < there; ++n) out[r * weights.outputs + first + n] = more[n] + all[n];
  }
}

constexpr int64_t kRows = 4, kPanels = 4;

/** A task's part of a step's products: samples row..row + kRows, panels panel..panel + kPanels. */
template <class T>
void multiply_task(const T* state, int64_t batch, const Weights<T>& weights, int64_t row, int64_t panel,
                   Added<T> added, T* sums) {
  const auto multiply_panel = [&](auto rows, auto panels, int64_t r, int64_t k) {
    multiply_rows<rows, panels>(state + r * weights.depth, weights, k,
                                Added<T>{added.data + r * added.row, added.row}, sums + r * weights.outputs);
  };
  constexpr std::integral_constant<int64_t, 1> one;
  constexpr std::integral_constant<int64_t, 4> four;
  const int64_t end_row = std::min(row + kRows, batch), end_panel = std::min(panel + kPanels, weights.count);
  if (end_row - row == kRows)
    for (int64_t k = panel; k < end_panel; ++k) multiply_panel(four, one, row, k);
  else if (end_panel - panel == kPanels)
    for (int64_t r = row; r < end_row; ++r) multiply_panel(one, four, r, panel);
  else
    for (int64_t r = row; r < end_row; ++r)
      for (int64_t k = panel; k < end_panel; ++k) multiply_panel(one, one, r, k);
}

/** Calls next(step, step before or -1, sample, sums) for each step and sample, where the sums are
 *  added(step) and the products of the hidden state of the step before: hidden, then what `out` has. */
template <class T, class MakeAdded, class Next>
void for_steps(int64_t steps, int64_t batch, const Weights<T>& weights, const T* hidden, bool reverse,
               const T* out, const MakeAdded& added, const Next& next) {
  constexpr int64_t kWork = 1 << 15;  // multiplications that are worth another thread
  std::vector<T> all_sums(static_cast<size_t>(batch * weights.outputs));
  T* const sums = all_sums.data();
  const int64_t chunks = (weights.count + kPanels - 1) / kPanels, blocks = (batch + kRows - 1) / kRows;
#pragma omp parallel if (batch * weights.outputs * weights.depth > kWork)
  for (int64_t step = 0; step < steps; ++step) {
    const int64_t t = reverse ? steps - 1 - step : step;
    const int64_t before = step == 0 ? -1 : reverse ? t + 1 : t - 1;
    const T* const state = before < 0 ? hidden : out + before * batch * weights.depth;
#pragma omp for
    for (int64_t task = 0; task < blocks * chunks; ++task)
      multiply_task(state, batch, weights, task / chunks * kRows, task % chunks * kPanels, added(t), sums);
#pragma omp for
    for (int64_t row = 0; row < batch; ++row) next(t, before, row, sums + row * weights.outputs);
  }
}

}  // namespace

template <class T>
void lstm(const T* gates, int64_t l, int64_t b, int64_t g, const T* weight, int64_t p, int64_t h,
          const T* hidden, const T* cell, bool reverse, T* out) {
  T* const cells = out + l * b * h;
  const auto added = [=](int64_t t) { return Added<T>{gates + t * b * g, g}; };
  for_steps(l, b, Weights<T>{weight, p, h, g}, hidden, reverse, out, added,
            [=](int64_t t, int64_t before, int64_t row, const T* sums) {
              const T* const memory = (before < 0 ? cell : cells + before * b * h) + row * h;
              T* const to = out + (t * b + row) * h;
              T* const to_cell = cells + (t * b + row) * h;
              for_lanes<T>(h, [=](auto d, auto, int64_t k) {
                const auto gate = [=](int64_t i) { return hn::LoadU(d, sums + i * h + k); };
                const auto kept = hn::Mul(sigmoid(gate(1)), hn::LoadU(d, memory + k));
                const auto next = hn::Add(kept, hn::Mul(sigmoid(gate(0)), hyperbolic_tangent(gate(2))));
                hn::StoreU(next, d, to_cell + k);
                hn::StoreU(hn::Mul(sigmoid(gate(3)), hyperbolic_tangent(next)), d, to + k);
              });
            });
}

template <class T>
void gru(const T* gates, int64_t l, int64_t b, int64_t g, const T* weight, int64_t p, int64_t h,
         const T* bias, const T* hidden, bool reverse, T* out) {
  const auto added = [=](int64_t) { return Added<T>{bias, 0}; };
  for_steps(l, b, Weights<T>{weight, p, h, g}, hidden, reverse, out, added,
            [=](int64_t t, int64_t before, int64_t row, const T* sums) {
              const T* const state = (before < 0 ? hidden : out + before * b * h) + row * h;
              const T* const from = gates + (t * b + row) * g;
              T* const to = out + (t * b + row) * h;
              for_lanes<T>(h, [=](auto d, auto, int64_t k) {
                const auto of_input = [=](int64_t i) { return hn::LoadU(d, from + i * h + k); };
                const auto of_state = [=](int64_t i) { return hn::LoadU(d, sums + i * h + k); };
                const auto reset = sigmoid(hn::Add(of_input(0), of_state(0)));
                const auto update = sigmoid(hn::Add(of_input(1), of_state(1)));
                const auto made = hyperbolic_tangent(hn::Add(of_input(2), hn::Mul(reset, of_state(2))));
                const auto kept = hn::LoadU(d, state + k);
                hn::StoreU(hn::Add(hn::Mul(hn::Sub(kept, made), update), made), d, to + k);
              });
            });
}

CHIASM_INSTANTIATE(lstm)
CHIASM_INSTANTIATE(gru)

}  // namespace chiasm::kernels
