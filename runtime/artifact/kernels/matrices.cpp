// Inverses and powers of many small matrices of doubles.
#include <algorithm>
#include <cmath>

#include "declared/matrices.h"
#include "lanes.h"

namespace chiasm::kernels {
namespace {

constexpr int64_t kRoom = kMostRows;
static_assert(kRoom % kLanes<double> == 0);

// Rows that are zeros from n up to the end of their last vector.
using Rows = double[kMostRows][kRoom];

// target += factor * row, over the vectors that n values fill.
inline void add(double* target, double factor, const double* row, int64_t n) {
  const Lanes<double> d;
  for (int64_t i = 0; i < n; i += kLanes<double>)
    hn::StoreU(hn::Add(hn::LoadU(d, target + i), hn::Mul(hn::Set(d, factor), hn::LoadU(d, row + i))), d,
               target + i);
}

inline void scale(double* row, double factor, int64_t n) {
  const Lanes<double> d;
  for (int64_t i = 0; i < n; i += kLanes<double>)
    hn::StoreU(hn::Mul(hn::LoadU(d, row + i), hn::Set(d, factor)), d, row + i);
}

void load(const double* m, int64_t n, Rows& rows) {
  for (int64_t r = 0; r < n; ++r) {
    std::fill(rows[r] + n / kLanes<double> * kLanes<double>, rows[r] + kRoom, 0.0);
    std::copy(m + r * n, m + (r + 1) * n, rows[r]);
  }
}

}  // namespace

void batched_inverse(const double* m, int64_t count, int64_t n, double* out) {
#pragma omp parallel for
  for (int64_t item = 0; item < count; ++item) {
    Rows left, right{};
    load(m + item * n * n, n, left);
    for (int64_t r = 0; r < n; ++r) right[r][r] = 1;
    int64_t order[kMostRows];
    bool used[kMostRows] = {};
    for (int64_t k = 0; k < n; ++k) {
      int64_t pick = -1;
      for (int64_t r = 0; r < n; ++r)
        if (!used[r] && (pick < 0 || std::abs(left[r][k]) > std::abs(left[pick][k]))) pick = r;
      used[pick] = true;
      order[k] = pick;
      const double factor = 1 / left[pick][k];
      scale(left[pick], factor, n);
      scale(right[pick], factor, n);
      for (int64_t r = 0; r < n; ++r) {
        if (r == pick) continue;
        const double part = -left[r][k];
        add(left[r], part, left[pick], n);
        add(right[r], part, right[pick], n);
      }
    }
    for (int64_t k = 0; k < n; ++k) std::copy(right[order[k]], right[order[k]] + n, out + (item * n + k) * n);
  }
}

void spd_inverse(const double* m, int64_t count, int64_t n, double* out) {
#pragma omp parallel for
  for (int64_t item = 0; item < count; ++item) {
    Rows rows;
    load(m + item * n * n, n, rows);
    for (int64_t k = 0; k < n; ++k) {
      // A sweep: exchanges unknown k with right-hand side k.
      const double factor = 1 / rows[k][k];
      rows[k][k] = 1;
      scale(rows[k], factor, n);
      for (int64_t r = 0; r < n; ++r) {
        if (r == k) continue;
        const double part = -rows[r][k];
        rows[r][k] = 0;
        add(rows[r], part, rows[k], n);
      }
    }
    for (int64_t r = 0; r < n; ++r) std::copy(rows[r], rows[r] + n, out + (item * n + r) * n);
  }
}

void normalized_power(const double* m, int64_t count, int64_t n, int64_t squarings, double* out) {
#pragma omp parallel for
  for (int64_t item = 0; item < count; ++item) {
    Rows power;
    load(m + item * n * n, n, power);
    for (int64_t s = 0; s < squarings; ++s) {
      double trace = 0;
      for (int64_t r = 0; r < n; ++r) trace += power[r][r];
      for (int64_t r = 0; r < n; ++r) scale(power[r], 1 / trace, n);
      Rows square;
      for (int64_t r = 0; r < n; ++r) {
        std::fill(square[r], square[r] + kRoom, 0.0);
        for (int64_t k = 0; k < n; ++k) add(square[r], power[r][k], power[k], n);
      }
      std::swap(power, square);
    }
    for (int64_t r = 0; r < n; ++r) std::copy(power[r], power[r] + n, out + (item * n + r) * n);
  }
}

}  // namespace chiasm::kernels
