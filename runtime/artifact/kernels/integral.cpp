// Summed-area tables.
#include "rows.h"

namespace chiasm::kernels {
namespace {

// A vector of four, or where there are only vectors of two, a pair of them: running sums are added in the
// same order on every CPU.
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

// Puts the running sums of four values in their place; each is added to its left neighbour, and then to what
// is two places to the left.
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

// A row's own sums first: what is added to those above is then a vector.
void integral_bytes(const uint8_t* x, Planes planes, int32_t* out) {
  constexpr int64_t kMost = INT32_MAX;
  const int64_t height = planes.height, width = planes.width;
#pragma omp parallel for
  for (int64_t plane = 0; plane < planes.count; ++plane) {
    for (int64_t y = plane * height; y < (plane + 1) * height; ++y) {
      const uint8_t* const row = x + y * width;
      int32_t* const to = out + y * width;
      int64_t sum = 0;
      for (int64_t k = 0; k < width; ++k) {
        sum += row[k];
        to[k] = static_cast<int32_t>(std::min(sum, kMost));
      }
      if (y == plane * height) continue;
      const int32_t* const above = to - width;
      for_lanes<int32_t>(width, [=](auto d, auto, int64_t k) {
        const hn::RebindToUnsigned<decltype(d)> wide;
        const auto total =
            hn::Add(hn::BitCast(wide, hn::LoadU(d, above + k)), hn::BitCast(wide, hn::LoadU(d, to + k)));
        hn::StoreU(hn::BitCast(d, hn::Min(total, hn::Set(wide, uint32_t{INT32_MAX}))), d, to + k);
      });
    }
  }
}

}  // namespace chiasm::kernels
