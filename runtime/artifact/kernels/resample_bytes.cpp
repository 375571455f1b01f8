// Resampling of bytes by any taps, along the rows and then down the columns, in integers.
#include <array>

#include "declared/resample_bytes.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

constexpr int kBits = 22;
constexpr int32_t kHalf = int32_t{1} << (kBits - 1);

using Four = hn::FixedTag<int32_t, 4>;

uint8_t rounded(uint32_t sum) {
  return static_cast<uint8_t>(std::clamp(static_cast<int32_t>(sum) >> kBits, 0, 255));
}

// The pixels that are summed, and their taps, for each pixel along an axis.
struct Axis {
  Axis(const int64_t* numbers, const int32_t* taps, int64_t count, int64_t each, int64_t size)
      : count(count), each(each), taps(taps), index(static_cast<size_t>(count * each)) {
    for (size_t i = 0; i < index.size(); ++i) index[i] = std::clamp<int64_t>(numbers[i], 0, size - 1);
  }
  const int64_t* of(int64_t i) const { return index.data() + i * each; }

  const int64_t count, each;
  const int32_t* const taps;
  std::vector<int64_t> index;
};

// A row of `length` values by the taps of `axis`, whose pixels have kStep values.
template <int kStep>
void resample_pixels(const uint8_t* row, int64_t length, const Axis& axis, uint8_t* out) {
  const Four d;
  const hn::Rebind<uint8_t, Four> bytes;
  for (int64_t i = 0; i < axis.count; ++i) {
    const int64_t* const index = axis.of(i);
    const int32_t* const taps = axis.taps + i * axis.each;
    auto sum = hn::Set(d, kHalf);
    for (int64_t k = 0; k < axis.each; ++k) {
      const int64_t at = index[k] * kStep;
      std::array<uint8_t, 4> last{};
      const uint8_t* pixel = row + at;
      if (at + 4 > length) {  // four bytes may be read only inside the row
        std::copy_n(pixel, kStep, last.data());
        pixel = last.data();
      }
      sum = hn::Add(sum, hn::Mul(hn::PromoteTo(d, hn::LoadU(bytes, pixel)), hn::Set(d, taps[k])));
    }
    hn::StoreU(hn::DemoteTo(bytes, hn::ShiftRight<kBits>(sum)), bytes, out + i * kStep);
  }
}

void resample_values(const uint8_t* row, int64_t step, const Axis& axis, uint8_t* out) {
  for (int64_t i = 0; i < axis.count; ++i) {
    const int64_t* const index = axis.of(i);
    const int32_t* const taps = axis.taps + i * axis.each;
    for (int64_t c = 0; c < step; ++c) {
      uint32_t sum = kHalf;
      for (int64_t k = 0; k < axis.each; ++k)
        sum += row[index[k] * step + c] * static_cast<uint32_t>(taps[k]);
      out[i * step + c] = rounded(sum);
    }
  }
}

// Writes up to three bytes more than a row has.
void resample_row(const uint8_t* row, int64_t length, int64_t step, const Axis& axis, uint8_t* out) {
  if (step == 3)
    resample_pixels<3>(row, length, axis, out);
  else if (step == 4)
    resample_pixels<4>(row, length, axis, out);
  else
    resample_values(row, step, axis, out);
}

// The sum of `each` rows, the k-th at rows + (index[k] - first) * stride.
void sum_rows(const uint8_t* rows, int64_t stride, const int64_t* index, int64_t first, const int32_t* taps,
              int64_t each, int64_t n, uint8_t* out) {
  for_lanes<int32_t, 2>(n, [=](auto d, auto vectors, int64_t i) {
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    for (int v = 0; v < vectors; ++v) {
      auto sum = hn::Set(d, kHalf);
      for (int64_t k = 0; k < each; ++k) {
        const auto values = hn::LoadU(bytes, rows + (index[k] - first) * stride + i + v * lanes);
        sum = hn::Add(sum, hn::Mul(hn::PromoteTo(d, values), hn::Set(d, taps[k])));
      }
      hn::StoreU(hn::DemoteTo(bytes, hn::ShiftRight<kBits>(sum)), bytes, out + i + v * lanes);
    }
  });
}

constexpr int64_t kRows = 32;

// The rows of the image from which some rows of the output are made.
struct RowsRead {
  RowsRead(const Axis& axis, int64_t top, int64_t bottom) {
    const auto ends = std::minmax_element(axis.of(top), axis.of(top) + (bottom - top) * axis.each);
    first = *ends.first, count = *ends.second - first + 1;
  }
  int64_t first, count;
};

}  // namespace

void resample_bytes(const uint8_t* x, int64_t n, int64_t height, int64_t length, const int64_t* rows,
                    int64_t new_height, int64_t row_taps, const int32_t* down, const int64_t* columns,
                    int64_t new_width, int64_t column_taps, const int32_t* across, int64_t step,
                    uint8_t* out) {
  const Axis vertical(rows, down, new_height, row_taps, height),
      horizontal(columns, across, new_width, column_taps, length / step);
  const int64_t blocks = (new_height + kRows - 1) / kRows, values = new_width * step,
                stride = whole_lines<uint8_t>(values + 3);
  int64_t most = 0;
  for (int64_t top = 0; top < new_height; top += kRows)
    most = std::max(most, RowsRead(vertical, top, std::min(top + kRows, new_height)).count);
  const auto memory = new_lines<uint8_t>(most * stride * omp_get_max_threads());
#pragma omp parallel for
  for (int64_t i = 0; i < n * blocks; ++i) {
    const int64_t top = i % blocks * kRows, bottom = std::min(top + kRows, new_height), image = i / blocks;
    const RowsRead read(vertical, top, bottom);
    uint8_t* const resampled = memory.get() + most * stride * omp_get_thread_num();
    for (int64_t y = 0; y < read.count; ++y)
      resample_row(x + (image * height + read.first + y) * length, length, step, horizontal,
                   resampled + y * stride);
    for (int64_t y = top; y < bottom; ++y)
      sum_rows(resampled, stride, vertical.of(y), read.first, down + y * row_taps, row_taps, values,
               out + (image * new_height + y) * values);
  }
}

}  // namespace chiasm::kernels
