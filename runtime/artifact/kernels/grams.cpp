// Normal matrices of least squares.
#include <algorithm>

#include "declared/grams.h"
#include "rows.h"

namespace chiasm::kernels {

void weighted_grams(const double* x, int64_t batch, int64_t rows, int64_t size, const double* weights,
                    int64_t sets, double* out) {
  constexpr int64_t kRoom = kMostRows, kBlock = 64;
  static_assert(kRoom % kLanes<double> == 0);
#pragma omp parallel for
  for (int64_t set = 0; set < batch * sets; ++set) {
    // Zeros from `size` up to the end of the last vector. Rows are summed in blocks, and then the blocks,
    // which accumulates less rounding error.
    double row[kRoom] = {}, block[kMostRows][kRoom], total[kMostRows][kRoom] = {};
    const double* const points = x + set / sets * rows * size;
    const double* const weight = weights + set / sets * rows * sets + set % sets;
    const Lanes<double> d;
    for (int64_t first = 0; first < rows; first += kBlock) {
      std::fill_n(block[0], size * kRoom, 0.0);
      for (int64_t n = first; n < std::min(first + kBlock, rows); ++n) {
        std::copy_n(points + n * size, size, row);
        for (int64_t i = 0; i < size; ++i) {
          const auto factor = hn::Set(d, weight[n * sets] * row[i]);
          for (int64_t j = 0; j < size; j += kLanes<double>)
            hn::StoreU(hn::Add(hn::LoadU(d, block[i] + j), hn::Mul(factor, hn::LoadU(d, row + j))), d,
                       block[i] + j);
        }
      }
      for (int64_t i = 0; i < size; ++i)
        for (int64_t j = 0; j < size; ++j) total[i][j] += block[i][j];
    }
    for (int64_t i = 0; i < size; ++i) std::copy_n(total[i], size, out + (set * size + i) * size);
  }
}

}  // namespace chiasm::kernels
