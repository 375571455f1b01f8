// Counting levels and looking them up: loops that follow the data, which compiled tensor code does by atomic
// additions and by gathers of 64-bit indices.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "declared/histograms.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// Four tables in turn: an increment does not wait for the previous one, which is often to the same bin.
constexpr int64_t kTables = 4;

// Counts those of n numbers that are valid bins; all of them if they are `known` to be valid.
template <bool known = false, class Index>
void count(const Index* index, int64_t n, int64_t bins, int32_t* tables) {
  int32_t *const a = tables, *const b = a + bins, *const c = b + bins, *const d = c + bins;
  const auto valid = [bins](Index i) {
    return known || static_cast<uint64_t>(i) < static_cast<uint64_t>(bins);
  };
  int64_t k = 0;
  for (; k + kTables <= n; k += kTables) {
    if (valid(index[k])) ++a[index[k]];
    if (valid(index[k + 1])) ++b[index[k + 1]];
    if (valid(index[k + 2])) ++c[index[k + 2]];
    if (valid(index[k + 3])) ++d[index[k + 3]];
  }
  for (; k < n; ++k)
    if (valid(index[k])) ++a[index[k]];
}

// Shares the counting of rows among threads: body(row, first, n, tables) counts n numbers into kTables
// tables, which are zero at first.
template <class Body>
void count_rows(int64_t rows, int64_t n, int64_t bins, int32_t* counts, const Body& body) {
  // Tasks are so large that counting takes longer than adding up their tables.
  const int64_t size = std::max<int64_t>(65536, 32 * bins),
                chunks = std::max<int64_t>(1, (n + size - 1) / size);
  const std::unique_ptr<int32_t[]> scratch(
      new int32_t[static_cast<size_t>(kTables * bins * omp_get_max_threads())]);
  std::fill_n(counts, rows * bins, 0);
#pragma omp parallel
  {
    int32_t* const tables = scratch.get() + kTables * bins * omp_get_thread_num();
#pragma omp for
    for (int64_t i = 0; i < rows * chunks; ++i) {
      const int64_t row = i / chunks, first = i % chunks * size;
      std::fill_n(tables, kTables * bins, 0);
      body(row, first, std::min(size, n - first), tables);
      for (int64_t k = 0; k < bins; ++k) {
        const int32_t sum = tables[k] + tables[bins + k] + tables[2 * bins + k] + tables[3 * bins + k];
        if (sum) {
#pragma omp atomic
          counts[row * bins + k] += sum;
        }
      }
    }
  }
}

}  // namespace

template <class Index>
void bincount(const Index* index, int64_t rows, int64_t n, int64_t bins, int32_t* counts) {
  count_rows(rows, n, bins, counts, [&](int64_t row, int64_t first, int64_t size, int32_t* tables) {
    count(index + row * n + first, size, bins, tables);
  });
}

namespace {

// The smallest and the greatest of n > 0 values, and whether one is NaN.
template <class T>
struct Extent {
  T least, greatest;
  bool undefined;
};

template <class T>
Extent<T> extent(const T* x, int64_t n) {
  const Lanes<T> d;
  constexpr int64_t lanes = kLanes<T>;
  T least = x[0], greatest = x[0];
  bool undefined = false;
  int64_t k = 0;
  if (n >= 4 * lanes) {
    // Four of each, which do not wait for each other.
    hn::Vec<Lanes<T>> low[4], high[4], order[4];
    for (int i = 0; i < 4; ++i) low[i] = high[i] = order[i] = hn::LoadU(d, x + i * lanes);
    for (; k + 4 * lanes <= n; k += 4 * lanes)
      for (int i = 0; i < 4; ++i) {
        const auto v = hn::LoadU(d, x + k + i * lanes);
        low[i] = smaller(low[i], v);
        high[i] = larger(high[i], v);
        order[i] = hn::Add(order[i], hn::Sub(v, v));  // becomes NaN if a value is NaN or infinite
      }
    T lows[lanes], highs[lanes];
    hn::StoreU(smaller(smaller(low[0], low[1]), smaller(low[2], low[3])), d, lows);
    hn::StoreU(larger(larger(high[0], high[1]), larger(high[2], high[3])), d, highs);
    least = *std::min_element(lows, lows + lanes);
    greatest = *std::max_element(highs, highs + lanes);
    if (any(d, hn::IsNaN(hn::Add(hn::Add(order[0], order[1]), hn::Add(order[2], order[3])))))
      undefined = std::any_of(x, x + k, [](T v) { return std::isnan(v); });
  }
  for (; k < n; ++k) {
    least = std::min(least, x[k]);
    greatest = std::max(greatest, x[k]);
    undefined = undefined || std::isnan(x[k]);
  }
  return {least, greatest, undefined};
}

}  // namespace

template <class T>
void aminmax(const T* x, int64_t rows, int64_t n, T* out) {
  constexpr int64_t size = 65536;
  const int64_t chunks = (n + size - 1) / size;
  std::vector<Extent<T>> parts(static_cast<size_t>(rows * chunks));
#pragma omp parallel for
  for (int64_t i = 0; i < rows * chunks; ++i) {
    const int64_t first = i % chunks * size;
    parts[static_cast<size_t>(i)] = extent(x + i / chunks * n + first, std::min(size, n - first));
  }
  for (int64_t row = 0; row < rows; ++row) {
    Extent<T> all = parts[static_cast<size_t>(row * chunks)];
    for (int64_t i = row * chunks; i < (row + 1) * chunks; ++i) {
      const Extent<T>& part = parts[static_cast<size_t>(i)];
      all = {std::min(all.least, part.least), std::max(all.greatest, part.greatest),
             all.undefined || part.undefined};
    }
    out[row] = all.undefined ? std::numeric_limits<T>::quiet_NaN() : all.least;
    out[rows + row] = all.undefined ? std::numeric_limits<T>::quiet_NaN() : all.greatest;
  }
}

CHIASM_INSTANTIATE(aminmax)

namespace {

// The bins of n values, limited before the conversion, because not every value fits into an integer; NaN goes
// to the first.
template <class T>
void place_in_bins(const T* x, int64_t n, T low, T span, T bins, int32_t* index) {
  for_lanes<T>(n, [=](auto d, auto, int64_t k) {
    const auto place =
        hn::Mul(hn::Div(hn::Sub(hn::LoadU(d, x + k), hn::Set(d, low)), hn::Set(d, span)), hn::Set(d, bins));
    const auto limited = smaller(larger(place, hn::Zero(d)), hn::Set(d, bins - 1));
    hn::StoreU(truncated(d, limited), Integers<decltype(d)>(), index + k);
  });
}

}  // namespace

template <class T>
void row_histograms(const T* x, int64_t rows, int64_t n, const T* low, const T* span, int64_t bins,
                    int32_t* counts) {
  constexpr int64_t kBlock = 512;
  count_rows(rows, n, bins, counts, [&](int64_t row, int64_t first, int64_t size, int32_t* tables) {
    const T* const values = x + row * n + first;
    const T least = low[row], width = span[row];
    int32_t index[kBlock];
    for (int64_t k = 0; k < size; k += kBlock) {
      const int64_t m = std::min(kBlock, size - k);
      place_in_bins(values + k, m, least, width, static_cast<T>(bins), index);
      count<true>(index, m, bins, tables);
    }
  });
}

CHIASM_INSTANTIATE(row_histograms)

namespace {

// If a number from 0 to 255 is added to this, the last bits are the number rounded half to even.
constexpr float kWhole = 8388608;

// The values as bytes, rounded half to even; NaN becomes 0.
template <class D>
HWY_INLINE hn::Vec<hn::Rebind<uint8_t, D>> to_bytes(D d, hn::Vec<D> v) {
  const auto limited = smaller(larger(v, hn::Zero(d)), hn::Set(d, 255));
  return hn::TruncateTo(hn::Rebind<uint8_t, D>(),
                        hn::BitCast(hn::RebindToUnsigned<D>(), hn::Add(limited, hn::Set(d, kWhole))));
}

template <class D>
HWY_INLINE hn::Vec<D> load_floats(D d, const float* p) {
  return hn::LoadU(d, p);
}

template <class D>
HWY_INLINE hn::Vec<D> load_floats(D d, const double* p) {
  using Part = hn::Rebind<float, hn::CappedTag<double, hn::MaxLanes(D())>>;
  return combined<Part>(
      d, [=](int64_t i) { return hn::DemoteTo(Part(), hn::LoadU(hn::Rebind<double, Part>(), p + i)); });
}

// The levels of n values, rounded half up. NaN becomes the lowest.
template <class T>
void find_levels(const T* x, int64_t n, uint8_t* levels) {
  for_lanes<float>(n, [=](auto d, auto, int64_t k) {
    const auto scaled =
        smaller(larger(hn::Mul(load_floats(d, x + k), hn::Set(d, 255)), hn::Zero(d)), hn::Set(d, 255));
    const auto rounded = hn::Add(scaled, hn::Set(d, kWhole));
    const hn::RebindToUnsigned<decltype(d)> integers;
    const auto half_down = hn::RebindMask(
        integers, hn::Eq(hn::Sub(scaled, hn::Sub(rounded, hn::Set(d, kWhole))), hn::Set(d, 0.5f)));
    // the mask as integers is -1 or 0
    const auto level = hn::Sub(hn::BitCast(integers, rounded), hn::VecFromMask(integers, half_down));
    hn::StoreU(hn::TruncateTo(hn::Rebind<uint8_t, decltype(d)>(), level), hn::Rebind<uint8_t, decltype(d)>(),
               levels + k);
  });
}

}  // namespace

template <class T>
void quantize_u8(const T* x, int64_t n, uint8_t* levels) {
  constexpr int64_t kBlock = 16384;
#pragma omp parallel for
  for (int64_t first = 0; first < n; first += kBlock)
    find_levels(x + first, std::min(kBlock, n - first), levels + first);
}

CHIASM_INSTANTIATE(quantize_u8)

CHIASM_INSTANTIATE(bincount)

template <class T>
void lut(const T* table, int64_t rows, const uint8_t* index, int64_t n, T* out) {
  constexpr int64_t size = 65536;
  const int64_t chunks = (n + size - 1) / size;
#pragma omp parallel for
  for (int64_t i = 0; i < rows * chunks; ++i) {
    const int64_t row = i / chunks, first = i % chunks * size, last = std::min(n, first + size);
    const T* const entries = table + row * 256;
#pragma GCC unroll 4  // else the time depends on where the loop begins in memory: up to 1.25 times
    for (int64_t k = row * n + first; k < row * n + last; ++k) out[k] = entries[index[k]];
  }
}

CHIASM_INSTANTIATE(lut)

void clahe_histograms(const uint8_t* levels, int64_t count_of_planes, int64_t height, int64_t width,
                      int64_t tile_height, int64_t tile_width, int64_t tiles_y, int64_t tiles_x,
                      int32_t* counts) {
  const int64_t tiles = tiles_y * tiles_x;
#pragma omp parallel for
  for (int64_t i = 0; i < count_of_planes * tiles; ++i) {
    const uint8_t* const plane = levels + i / tiles * height * width;
    const int64_t top = i % tiles / tiles_x * tile_height, left = i % tiles_x * tile_width;
    const int64_t within = std::clamp<int64_t>(width - left, 0, tile_width);
    std::array<int32_t, kTables * 256> tables{};
    for (int64_t y = top; y < top + tile_height; ++y) {
      const uint8_t* const row = plane + inside(y, height, Border::kReflect) * width;
      count(row + left, within, 256, tables.data());
      for (int64_t x = left + within; x < left + tile_width; ++x)
        ++tables[row[inside(x, width, Border::kReflect)]];
    }
    for (int64_t k = 0; k < 256; ++k)
      counts[i * 256 + k] = tables[k] + tables[256 + k] + tables[512 + k] + tables[768 + k];
  }
}

namespace {

// The levels of n pixels by the curves a, b, c, d of the tiles to the left and right above, and below.
void blend(const float* a, const float* b, const float* c, const float* d, const uint8_t* in, int64_t n,
           const float* weight, float weight_below, uint8_t* out) {
  for_lanes<float>(n, [=](auto tag, auto, int64_t k) {
    const hn::Rebind<uint8_t, decltype(tag)> bytes;
    const auto level = hn::PromoteTo(Integers<decltype(tag)>(), hn::LoadU(bytes, in + k));
    // All gathers come before their use: otherwise the compiler makes a gather wait for the register that was
    // the mask of the previous one.
    const auto upper_left = hn::GatherIndex(tag, a, level), upper_right = hn::GatherIndex(tag, b, level);
    const auto lower_left = hn::GatherIndex(tag, c, level), lower_right = hn::GatherIndex(tag, d, level);
    const auto right = hn::LoadU(tag, weight + k), left = hn::Sub(hn::Set(tag, 1), right);
    const auto below = hn::Set(tag, weight_below), above = hn::Set(tag, 1 - weight_below);
    const auto upper = hn::Add(hn::Mul(upper_left, left), hn::Mul(upper_right, right)),
               lower = hn::Add(hn::Mul(lower_left, left), hn::Mul(lower_right, right));
    hn::StoreU(to_bytes(tag, hn::Add(hn::Mul(upper, above), hn::Mul(lower, below))), bytes, out + k);
  });
}

}  // namespace

void clahe_interpolate(const float* table, int64_t planes, int64_t tiles, int64_t tiles_x,
                       const uint8_t* levels, int64_t height, int64_t width, const int64_t* first_y,
                       const int64_t* second_y, const float* weight_y, const int64_t* first_x,
                       const int64_t* second_x, const float* weight_x, uint8_t* out) {
  // The pixels between the centres of two tiles use the same curves. These are the ends of such stretches.
  std::vector<int64_t> ends;
  for (int64_t x = 1; x <= width; ++x)
    if (x == width || first_x[x] != first_x[x - 1] || second_x[x] != second_x[x - 1]) ends.push_back(x);
#pragma omp parallel for
  for (int64_t i = 0; i < planes * height; ++i) {
    const int64_t y = i % height;
    const float* const curves = table + i / height * tiles * 256;
    const float *const upper = curves + first_y[y] * tiles_x * 256, *const lower =
                                                                        curves + second_y[y] * tiles_x * 256;
    const uint8_t* const in = levels + i * width;
    uint8_t* const target = out + i * width;
    int64_t x = 0;
    for (const int64_t end : ends) {
      const int64_t tile = 256 * first_x[x], next = 256 * second_x[x];
      blend(upper + tile, upper + next, lower + tile, lower + next, in + x, end - x, weight_x + x,
            weight_y[y], target + x);
      x = end;
    }
  }
}

}  // namespace chiasm::kernels
