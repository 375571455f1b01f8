// Summed-area tables.
#include <vector>

#include "declared/integral.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// A vector of four, or two vectors of two if the CPU has no longer ones, so that running sums are added in
// the same order on every CPU.
using Part = hn::CappedTag<double, 4>;
using V = hn::Vec<Part>;
constexpr int64_t kPart = static_cast<int64_t>(hn::MaxLanes(Part()));
static_assert(kPart == 2 || kPart == 4);

V load(const float* p) { return hn::PromoteTo(Part(), hn::LoadU(hn::Rebind<float, Part>(), p)); }
V load(const double* p) { return hn::LoadU(Part(), p); }
void store(float* p, V v) {
  hn::StoreU(hn::DemoteTo(hn::Rebind<float, Part>(), v), hn::Rebind<float, Part>(), p);
}
void store(double* p, V v) { hn::StoreU(v, Part(), p); }
V rounded(V v, float) { return hn::PromoteTo(Part(), hn::DemoteTo(hn::Rebind<float, Part>(), v)); }
V rounded(V v, double) { return v; }

// The sum of four values and those before them, in all lanes.
V total(V sums) {
  const int64_t last[] = {kPart - 1, kPart - 1, kPart - 1, kPart - 1};
  return hn::TableLookupLanes(sums, hn::SetTableIndices(Part(), last));
}

// Replaces four values by their running sums: adds to each its left neighbour, and then the value two places
// to the left.
template <class T>
void running(const T* row, V* sums) {
  const Part d;
  if constexpr (kPart == 4) {
    const int64_t left[] = {0, 0, 1, 2};
    const V values = load(row), neighbours = hn::TableLookupLanes(values, hn::SetTableIndices(d, left));
    const V pairs = hn::Add(values, hn::IfThenZeroElse(hn::FirstN(d, 1), neighbours));
    sums[0] = hn::Add(pairs, hn::ConcatLowerLower(d, pairs, hn::Zero(d)));
  } else {
    const V low = load(row), high = load(row + 2);
    sums[0] = hn::Add(low, hn::ConcatLowerUpper(d, low, hn::Zero(d)));
    sums[1] = hn::Add(hn::Add(high, hn::ConcatLowerUpper(d, high, low)), sums[0]);
  }
}

// `above` has the columns' sums so far.
template <class T>
void add_row(const T* row, int64_t width, double* above, T* target) {
  const Part d;
  V left = hn::Zero(d);
  int64_t k = 0;
  for (; k + 4 <= width; k += 4) {
    V sums[4 / kPart];
    running(row + k, sums);
    for (int64_t i = 0; i < 4 / kPart; ++i) {
      const int64_t x = k + i * kPart;
      const V sum = hn::Add(hn::LoadU(d, above + x), rounded(hn::Add(sums[i], left), T{}));
      hn::StoreU(sum, d, above + x);
      store(target + x, sum);
    }
    left = hn::Add(left, total(sums[4 / kPart - 1]));
  }
  double sum = hn::GetLane(left);
  for (; k < width; ++k) {
    sum += static_cast<double>(row[k]);
    above[k] += static_cast<double>(static_cast<T>(sum));
    target[k] = static_cast<T>(above[k]);
  }
}

}  // namespace

template <class T>
void integral(const T* x, Planes planes, T* out) {
  const int64_t height = planes.height, width = planes.width;
  const std::unique_ptr<double[]> columns(new double[static_cast<size_t>(width * omp_get_max_threads())]);
#pragma omp parallel
  {
    double* const above = columns.get() + width * omp_get_thread_num();
#pragma omp for
    for (int64_t plane = 0; plane < planes.count; ++plane) {
      std::fill_n(above, width, 0.0);
      for (int64_t y = plane * height; y < (plane + 1) * height; ++y)
        add_row(x + y * width, width, above, out + y * width);
    }
  }
}

CHIASM_INSTANTIATE(integral)

namespace {

constexpr uint32_t kMost = INT32_MAX;

// A row of a plane: the row's own sums first, so that adding the sums above is one vector operation.
void sum_values(const uint8_t* row, const int32_t* above, int64_t width, int32_t* to) {
  int64_t sum = 0;
  for (int64_t k = 0; k < width; ++k) {
    sum += row[k];
    to[k] = static_cast<int32_t>(std::min(sum, int64_t{kMost}));
  }
  if (above == nullptr) return;
  for_lanes<int32_t>(width, [=](auto d, auto, int64_t k) {
    const hn::RebindToUnsigned<decltype(d)> wide;
    const auto total =
        hn::Add(hn::BitCast(wide, hn::LoadU(d, above + k)), hn::BitCast(wide, hn::LoadU(d, to + k)));
    hn::StoreU(hn::BitCast(d, hn::Min(total, hn::Set(wide, kMost))), d, to + k);
  });
}

// A row of pixels of kStep values, 3 or 4: a vector has the sums of all channels. At each pixel but the last,
// four values are read and written; the next pixel overwrites the excess ones.
template <int kStep>
void sum_pixels(const uint8_t* row, const int32_t* above, int64_t width, int32_t* to) {
  const hn::FixedTag<uint32_t, 4> d;
  const hn::RebindToSigned<decltype(d)> integers;
  const hn::Rebind<uint8_t, decltype(d)> bytes;
  const auto most = hn::Set(d, kMost);
  auto sum = hn::Zero(d);
  const auto step = [&](const uint8_t* pixel, const int32_t* higher) {
    sum = hn::Min(hn::Add(sum, hn::PromoteTo(d, hn::LoadU(bytes, pixel))), most);
    if (higher == nullptr) return hn::BitCast(integers, sum);
    const auto before = hn::BitCast(d, hn::LoadU(integers, higher));
    return hn::BitCast(integers, hn::Min(hn::Add(sum, before), most));
  };
  const int64_t last = width - kStep;
  for (int64_t k = 0; k < last; k += kStep)
    hn::StoreU(step(row + k, above == nullptr ? nullptr : above + k), integers, to + k);
  uint8_t pixel[4] = {};
  int32_t higher[4] = {}, total[4];
  std::copy_n(row + last, kStep, pixel);
  if (above != nullptr) std::copy_n(above + last, kStep, higher);
  hn::StoreU(step(pixel, higher), integers, total);
  std::copy_n(total, kStep, to + last);
}

// A row of pixels of any number of values.
void sum_steps(const uint8_t* row, const int32_t* above, int64_t width, int64_t step, int32_t* to) {
  for (int64_t c = 0; c < step; ++c) {
    int64_t sum = 0;
    for (int64_t k = c; k < width; k += step) {
      sum = std::min(sum + row[k], int64_t{kMost});
      to[k] = static_cast<int32_t>(std::min(sum + (above == nullptr ? 0 : above[k]), int64_t{kMost}));
    }
  }
}

// Adds the bytes of `rows` rows to their columns' sums.
void add_columns(const uint8_t* x, int64_t rows, int64_t length, int32_t* sums) {
  for (int64_t y = 0; y < rows; ++y)
    for_lanes<int32_t>(length, [=](auto d, auto, int64_t k) {
      const hn::RebindToUnsigned<decltype(d)> wide;
      const hn::Rebind<uint8_t, decltype(d)> bytes;
      const auto sum = hn::Add(hn::BitCast(wide, hn::LoadU(d, sums + k)),
                               hn::PromoteTo(wide, hn::LoadU(bytes, x + y * length + k)));
      hn::StoreU(hn::BitCast(d, hn::Min(sum, hn::Set(wide, kMost))), d, sums + k);
    });
}

// a + b, at most the largest number.
int32_t limited_sum(int64_t a, int64_t b) { return static_cast<int32_t>(std::min(a + b, int64_t{kMost})); }

// Rows of a plane, below a row of sums unless it is nullptr.
void sum_rows(const uint8_t* x, int64_t rows, int64_t length, int64_t step, const int32_t* above,
              int32_t* out) {
  for (int64_t y = 0; y < rows; ++y) {
    const uint8_t* const row = x + y * length;
    int32_t* const to = out + y * length;
    switch (step) {
      case 1: sum_values(row, above, length, to); break;
      case 3: sum_pixels<3>(row, above, length, to); break;
      case 4: sum_pixels<4>(row, above, length, to); break;
      default: sum_steps(row, above, length, step, to);
    }
    above = to;
  }
}

}  // namespace

void integral_bytes(const uint8_t* x, int64_t n, int64_t height, int64_t length, int64_t step, int32_t* out) {
  // If there are fewer planes than threads, a plane is divided into strips of rows. Each begins below the
  // sums of the strips above, which are those of their columns, added up along the row.
  constexpr int64_t kLeast = 64;  // rows
  const int64_t threads = omp_get_max_threads();
  const int64_t strips = n >= threads ? 1 : std::clamp<int64_t>(height / kLeast, 1, threads);
  const auto first = [=](int64_t strip) { return height * strip / strips; };
  std::vector<int32_t> columns(strips == 1 ? 0 : static_cast<size_t>(n * strips * length));
  int32_t* const of_columns = columns.data();
  if (strips > 1) {
#pragma omp parallel for
    for (int64_t i = 0; i < n * strips; ++i) {
      const int64_t top = first(i % strips), rows = first(i % strips + 1) - top;
      add_columns(x + (i / strips * height + top) * length, rows, length, of_columns + i * length);
    }
    for (int64_t i = 0; i < n * strips; ++i) {
      int32_t* const sums = of_columns + i * length;
      if (i % strips > 0)
        for (int64_t k = 0; k < length; ++k) sums[k] = limited_sum(sums[k], (sums - length)[k]);
    }
    for (int64_t i = 0; i < n * strips; ++i) {
      int32_t* const sums = of_columns + i * length;
      for (int64_t k = step; k < length; ++k) sums[k] = limited_sum(sums[k], sums[k - step]);
    }
  }
#pragma omp parallel for
  for (int64_t i = 0; i < n * strips; ++i) {
    const int64_t top = first(i % strips), rows = first(i % strips + 1) - top;
    const int64_t at = (i / strips * height + top) * length;
    sum_rows(x + at, rows, length, step, i % strips > 0 ? of_columns + (i - 1) * length : nullptr, out + at);
  }
}

}  // namespace chiasm::kernels
