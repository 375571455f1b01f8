// Nearest neighbours among descriptors: all distances, and the least of each row or column.
#include <omp.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "kernels.h"
#include "vectors.h"

namespace chiasm::kernels {
namespace {

// Products of four descriptors with twelve: as many sums as there are registers for.
constexpr int64_t kRows = 4, kColumns = 12, kLanes = 4;

// `size` descriptors as doubles, in groups: entry after entry, of each entry those of the group. The last group is filled up with zeros.
template <class T>
void pack(const T* x, int64_t size, int64_t depth, int64_t group, double* out) {
  for (int64_t k = 0; k < depth; ++k)
    for (int64_t i = 0; i < group; ++i) *out++ = i < size ? static_cast<double>(x[i * depth + k]) : 0.0;
}

inline void multiply(const double* rows, const double* columns, int64_t depth, double* products) {
  __m256d sums[kRows][kColumns / kLanes];
  for (auto& row : sums)
    for (auto& sum : row) sum = _mm256_setzero_pd();
  for (int64_t k = 0; k < depth; ++k, rows += kRows, columns += kColumns) {
    const __m256d a = _mm256_loadu_pd(columns), b = _mm256_loadu_pd(columns + kLanes), c = _mm256_loadu_pd(columns + 2 * kLanes);
#pragma GCC unroll 4
    for (int64_t r = 0; r < kRows; ++r) {
      const __m256d factor = _mm256_broadcast_sd(rows + r);
      sums[r][0] = _mm256_fmadd_pd(factor, a, sums[r][0]);
      sums[r][1] = _mm256_fmadd_pd(factor, b, sums[r][1]);
      sums[r][2] = _mm256_fmadd_pd(factor, c, sums[r][2]);
    }
  }
  for (const auto& row : sums)
    for (const auto& sum : row) {
      _mm256_storeu_pd(products, sum);
      products += kLanes;
    }
}

template <class T>
std::vector<double> squared_lengths(const T* x, int64_t size, int64_t depth) {
  std::vector<double> lengths(static_cast<size_t>(size));
  for (int64_t i = 0; i < size; ++i)
    for (int64_t k = 0; k < depth; ++k) lengths[static_cast<size_t>(i)] += static_cast<double>(x[i * depth + k]) * static_cast<double>(x[i * depth + k]);
  return lengths;
}

bool is_zero(const std::vector<double>& lengths, int64_t first, int64_t count) {
  const int64_t end = std::min(first + count, static_cast<int64_t>(lengths.size()));
  return std::all_of(lengths.begin() + first, lengths.begin() + end, [](double length) { return length == 0; });
}

}  // namespace

template <class T>
void squared_distances(const T* a, const T* b, int64_t batch, int64_t rows, int64_t columns, int64_t depth, T* out) {
  const int64_t row_groups = (rows + kRows - 1) / kRows, column_groups = (columns + kColumns - 1) / kColumns;
  std::vector<double> left(static_cast<size_t>(row_groups * kRows * depth)), right(static_cast<size_t>(kColumns * depth * omp_get_max_threads()));
  for (int64_t item = 0; item < batch; ++item, a += rows * depth, b += columns * depth, out += rows * columns) {
    const auto row_lengths = squared_lengths(a, rows, depth), column_lengths = squared_lengths(b, columns, depth);
    for (int64_t g = 0; g < row_groups; ++g) pack(a + g * kRows * depth, rows - g * kRows, depth, kRows, left.data() + g * kRows * depth);
#pragma omp parallel for
    for (int64_t c = 0; c < column_groups; ++c) {
      double* const own = right.data() + kColumns * depth * omp_get_thread_num();
      const int64_t first = c * kColumns, wide = std::min(kColumns, columns - first);
      pack(b + first * depth, wide, depth, kColumns, own);
      for (int64_t r = 0; r < row_groups; ++r) {
        double products[kRows * kColumns] = {};
        // Empty slots are zeros, and stand together.
        if (!is_zero(row_lengths, r * kRows, kRows) && !is_zero(column_lengths, first, wide)) multiply(left.data() + r * kRows * depth, own, depth, products);
        for (int64_t i = 0; i < std::min(kRows, rows - r * kRows); ++i) {
          const int64_t row = r * kRows + i;
          for (int64_t k = 0; k < wide; ++k)
            out[row * columns + first + k] =
                static_cast<T>(row_lengths[static_cast<size_t>(row)] + column_lengths[static_cast<size_t>(first + k)] - 2 * products[i * kColumns + k]);
        }
      }
    }
  }
}

namespace {

// The two least values so far, and where they are.
template <class T>
struct Two {
  T first = std::numeric_limits<T>::infinity(), second = first;
  int64_t first_place = -1, second_place = -1;

  void see(T value, int64_t place) {
    if (!(value < second)) return;
    const bool best = value < first;
    second = best ? first : value;
    second_place = best ? first_place : place;
    first = best ? value : first;
    first_place = best ? place : first_place;
  }
};

}  // namespace

template <class T>
void two_least(const T* x, Planes planes, bool along_rows, int64_t* out) {
  constexpr int64_t kStrip = 256;
  const int64_t height = planes.height, width = planes.width, tasks = along_rows ? height : (width + kStrip - 1) / kStrip;
#pragma omp parallel for
  for (int64_t task = 0; task < planes.count * tasks; ++task) {
    const T* const plane = x + task / tasks * height * width;
    const int64_t i = task % tasks, first = along_rows ? i : i * kStrip, last = along_rows ? i + 1 : std::min(first + kStrip, width);
    Two<T> least[kStrip];
    if (along_rows) {
      for (int64_t k = 0; k < width; ++k) least[0].see(plane[i * width + k], k);
    } else {
      for (int64_t row = 0; row < height; ++row)
        for (int64_t k = first; k < last; ++k) least[k - first].see(plane[row * width + k], row);
    }
    int64_t* target = out + 2 * (task / tasks * (along_rows ? height : width) + first);
    for (int64_t k = 0; k < last - first; ++k) {
      *target++ = least[k].first_place;
      *target++ = least[k].second_place;
    }
  }
}

template void squared_distances(const float*, const float*, int64_t, int64_t, int64_t, int64_t, float*);
template void squared_distances(const double*, const double*, int64_t, int64_t, int64_t, int64_t, double*);
template void two_least(const float*, Planes, bool, int64_t*);
template void two_least(const double*, Planes, bool, int64_t*);

}  // namespace chiasm::kernels
