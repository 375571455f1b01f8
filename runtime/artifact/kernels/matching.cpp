// Nearest neighbours among descriptors: all distances, and the smallest of each row or column.
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "declared/matching.h"
#include "lanes.h"

namespace chiasm::kernels {
namespace {

// The products of four descriptors with three vectors of descriptors: as many sums as fit into registers.
constexpr int64_t kRows = 4, kColumns = 3 * kLanes<double>;

// `size` descriptors as doubles, in groups; within a group entry by entry, all descriptors of the group next
// to each other. The last group is padded with zeros.
template <class T>
void pack(const T* x, int64_t size, int64_t depth, int64_t group, double* out) {
  for (int64_t k = 0; k < depth; ++k)
    for (int64_t i = 0; i < group; ++i) *out++ = i < size ? static_cast<double>(x[i * depth + k]) : 0.0;
}

inline void multiply(const double* rows, const double* columns, int64_t depth, double* products) {
  const Lanes<double> d;
  constexpr int64_t lanes = kLanes<double>;
  hn::Vec<Lanes<double>> sums[kRows][kColumns / lanes];
  for (auto& row : sums)
    for (auto& sum : row) sum = hn::Zero(d);
  for (int64_t k = 0; k < depth; ++k, rows += kRows, columns += kColumns) {
    const auto a = hn::LoadU(d, columns), b = hn::LoadU(d, columns + lanes),
               c = hn::LoadU(d, columns + 2 * lanes);
#pragma GCC unroll 4
    for (int64_t r = 0; r < kRows; ++r) {
      const auto factor = hn::Set(d, rows[r]);
      sums[r][0] = hn::MulAdd(factor, a, sums[r][0]);
      sums[r][1] = hn::MulAdd(factor, b, sums[r][1]);
      sums[r][2] = hn::MulAdd(factor, c, sums[r][2]);
    }
  }
  for (const auto& row : sums)
    for (const auto& sum : row) {
      hn::StoreU(sum, d, products);
      products += lanes;
    }
}

template <class T>
std::vector<double> squared_lengths(const T* x, int64_t size, int64_t depth) {
  std::vector<double> lengths(static_cast<size_t>(size));
  for (int64_t i = 0; i < size; ++i)
    for (int64_t k = 0; k < depth; ++k)
      lengths[static_cast<size_t>(i)] +=
          static_cast<double>(x[i * depth + k]) * static_cast<double>(x[i * depth + k]);
  return lengths;
}

// Whether the products of these descriptors are all zero: one side is zero, and the other has no infinity or
// NaN.
bool have_no_products(const std::vector<double>& rows, int64_t row, const std::vector<double>& columns,
                      int64_t column) {
  const auto each = [](const std::vector<double>& lengths, int64_t first, int64_t group, auto is) {
    const int64_t end = std::min(first + group, static_cast<int64_t>(lengths.size()));
    return std::all_of(lengths.begin() + first, lengths.begin() + end, is);
  };
  const auto zero = [](double length) { return length == 0; };
  const auto finite = [](double length) { return std::isfinite(length); };
  return (each(rows, row, kRows, zero) && each(columns, column, kColumns, finite)) ||
         (each(columns, column, kColumns, zero) && each(rows, row, kRows, finite));
}

}  // namespace

template <class T>
void cdist_squared(const T* a, int64_t batch, int64_t rows, int64_t depth, const T* b, int64_t columns,
                   T* out) {
  const int64_t row_groups = (rows + kRows - 1) / kRows, column_groups = (columns + kColumns - 1) / kColumns;
  std::vector<double> left(static_cast<size_t>(row_groups * kRows * depth)),
      right(static_cast<size_t>(kColumns * depth * omp_get_max_threads()));
  for (int64_t item = 0; item < batch;
       ++item, a += rows * depth, b += columns * depth, out += rows * columns) {
    const auto row_lengths = squared_lengths(a, rows, depth),
               column_lengths = squared_lengths(b, columns, depth);
    for (int64_t g = 0; g < row_groups; ++g)
      pack(a + g * kRows * depth, rows - g * kRows, depth, kRows, left.data() + g * kRows * depth);
#pragma omp parallel for
    for (int64_t c = 0; c < column_groups; ++c) {
      double* const own = right.data() + kColumns * depth * omp_get_thread_num();
      const int64_t first = c * kColumns, wide = std::min(kColumns, columns - first);
      pack(b + first * depth, wide, depth, kColumns, own);
      for (int64_t r = 0; r < row_groups; ++r) {
        double products[kRows * kColumns] = {};
        // Empty slots are zeros, and adjacent.
        if (!have_no_products(row_lengths, r * kRows, column_lengths, first))
          multiply(left.data() + r * kRows * depth, own, depth, products);
        for (int64_t i = 0; i < std::min(kRows, rows - r * kRows); ++i) {
          const int64_t row = r * kRows + i;
          for (int64_t k = 0; k < wide; ++k)
            out[row * columns + first + k] = static_cast<T>(row_lengths[static_cast<size_t>(row)] +
                                                            column_lengths[static_cast<size_t>(first + k)] -
                                                            2 * products[i * kColumns + k]);
        }
      }
    }
  }
}

namespace {

constexpr int64_t kStrip = 256;

// The two smallest values so far of each of some series, and their indices.
template <class T>
struct TwoSmallest {
  explicit TwoSmallest(int64_t count) {
    std::fill_n(first, count, std::numeric_limits<T>::infinity());
    std::fill_n(second, count, std::numeric_limits<T>::infinity());
    std::fill_n(first_place, count, -1);
    std::fill_n(second_place, count, -1);
  }

  void see(int64_t k, T value, int64_t place) {
    if (!(value < second[k])) return;
    const bool best = value < first[k];
    second[k] = best ? first[k] : value;
    second_place[k] = best ? first_place[k] : place;
    first[k] = best ? value : first[k];
    first_place[k] = best ? place : first_place[k];
  }

  // n more values of the first series. Few are among the smallest, so most vectors are skipped as a whole.
  void see_all(const T* values, int64_t n) {
    int64_t i = 0;
    const Lanes<T> d;
    for (; i + kLanes<T> <= n; i += kLanes<T>) {
      if (!any(d, hn::Lt(hn::LoadU(d, values + i), hn::Set(d, second[0])))) continue;
      for (int64_t j = i; j < i + kLanes<T>; ++j) see(0, values[j], j);
    }
    for (; i < n; ++i) see(0, values[i], i);
  }

  // The value at index `place` of each of n series.
  void see_each(const T* values, int64_t n, int64_t place) {
    int64_t k = 0;
    const Lanes<T> d;
    for (; k + kLanes<T> <= n; k += kLanes<T>) {
      if (!any(d, hn::Lt(hn::LoadU(d, values + k), hn::LoadU(d, second + k)))) continue;
      for (int64_t j = k; j < k + kLanes<T>; ++j) see(j, values[j], place);
    }
    for (; k < n; ++k) see(k, values[k], place);
  }

  T first[kStrip], second[kStrip];
  int64_t first_place[kStrip], second_place[kStrip];
};

}  // namespace

template <class T>
void two_smallest(const T* x, int64_t batch, int64_t height, int64_t width, bool along_rows, int64_t* out) {
  const int64_t tasks = along_rows ? height : (width + kStrip - 1) / kStrip;
#pragma omp parallel for
  for (int64_t task = 0; task < batch * tasks; ++task) {
    const T* const plane = x + task / tasks * height * width;
    const int64_t i = task % tasks, first = along_rows ? i : i * kStrip,
                  last = along_rows ? i + 1 : std::min(first + kStrip, width);
    TwoSmallest<T> least(last - first);
    if (along_rows) {
      least.see_all(plane + i * width, width);
    } else {
      for (int64_t row = 0; row < height; ++row)
        least.see_each(plane + row * width + first, last - first, row);
    }
    int64_t* target = out + 2 * (task / tasks * (along_rows ? height : width) + first);
    for (int64_t k = 0; k < last - first; ++k) {
      *target++ = least.first_place[k];
      *target++ = least.second_place[k];
    }
  }
}

CHIASM_INSTANTIATE(cdist_squared)
CHIASM_INSTANTIATE(two_smallest)

}  // namespace chiasm::kernels
