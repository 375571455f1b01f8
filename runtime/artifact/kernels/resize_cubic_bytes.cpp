// Bicubic resizing of bytes: rows are first resampled along their length into 32-bit sums; the last four such
// rows are kept and weighted.
#include <array>
#include <cstring>

#include "declared/resize_cubic_bytes.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

constexpr int kTaps = 4;
constexpr int kBits = 22;  // the fraction bits of a product of two weights
constexpr uint32_t kHalf = uint32_t{1} << (kBits - 1);

using Four = hn::FixedTag<int32_t, 4>;

// Two weights of 16 bits in one integer.
int32_t pair(int64_t first, int64_t second) {
  return static_cast<int32_t>(static_cast<uint32_t>(first & 0xFFFF) | static_cast<uint32_t>(second) << 16);
}

// Four values at p; in a vector of eight, the other four are `apart` after them.
template <class D>
HWY_INLINE void store_fours(D d, hn::Vec<D> values, int32_t* p, int64_t apart) {
  const Four four;
  if constexpr (hn::MaxLanes(D()) == 4) {
    hn::StoreU(values, d, p);
  } else {
    hn::StoreU(hn::LowerHalf(four, values), four, p);
    hn::StoreU(hn::UpperHalf(four, values), four, p + apart);
  }
}

// The pixels that are summed, and their weights, for each pixel along an axis.
struct Axis {
  Axis(const int64_t* numbers, const int64_t* weights, int64_t count, int64_t size)
      : count(count), weights(weights), index(static_cast<size_t>(count * kTaps)) {
    for (size_t i = 0; i < index.size(); ++i) index[i] = std::clamp<int64_t>(numbers[i], 0, size - 1);
  }
  const int64_t* of(int64_t i) const { return index.data() + i * kTaps; }

  const int64_t count;
  const int64_t* const weights;
  std::vector<int64_t> index;
};

// Resamples a row. For pixels begin to end of the output, the four pixels that are summed are neighbours,
// from the value `first` on, and whole vectors can be loaded there.
class Across {
 public:
  Across(const Axis& axis, int64_t length, int64_t step) : axis_(axis), step_(step) {
    const int64_t wide = step == 1 ? 4 : 16;
    const auto together = [&](int64_t i) {
      const int64_t* const index = axis.of(i);
      return index[0] * step + wide <= length && index[1] == index[0] + 1 && index[2] == index[0] + 2 &&
             index[3] == index[0] + 3;
    };
    if (step == 1 || step == 3 || step == 4) {
      while (begin_ < axis.count && !together(begin_)) ++begin_;
      end_ = begin_;
      while (end_ < axis.count && together(end_)) ++end_;
    }
    const size_t each = step == 1 ? 1 : 4;  // one per channel
    for (int64_t i = 0; i < axis.count; ++i) {
      const int64_t* const weight = axis.weights + i * kTaps;
      first_.push_back(static_cast<int32_t>(*axis.of(i) * step));
      even_.insert(even_.end(), each, pair(weight[0], weight[2]));
      odd_.insert(odd_.end(), each, pair(weight[1], weight[3]));
    }
  }

  // Room for a row: vectors of four run over its end.
  int64_t room() const { return whole_lines<int32_t>(axis_.count * step_ + 4); }

  void operator()(const uint8_t* row, int32_t* out) const {
    one_by_one(row, 0, begin_, out);
    int64_t done = begin_;
    if (step_ == 1)
      done = planes(row, out);
    else if (step_ == 3)
      done = pixels<3>(row, out);
    else if (step_ == 4)
      done = pixels<4>(row, out);
    one_by_one(row, done, axis_.count, out);
  }

 private:
  void one_by_one(const uint8_t* row, int64_t i, int64_t end, int32_t* out) const {
    for (; i < end; ++i) {
      const int64_t *const index = axis_.of(i), *const weight = axis_.weights + i * kTaps;
      for (int64_t c = 0; c < step_; ++c) {
        int64_t sum = 0;
        for (int64_t k = 0; k < kTaps; ++k) sum += row[index[k] * step_ + c] * weight[k];
        out[i * step_ + c] = static_cast<int32_t>(sum);
      }
    }
  }

  // Both return the end of the pixels that they have computed.
  template <int kStep>
  int64_t pixels(const uint8_t* row, int32_t* out) const {
    const hn::CappedTag<uint8_t, 32> bytes;  // one pixel, or two
    const hn::FixedTag<uint8_t, 16> part;
    const hn::Repartition<int16_t, decltype(bytes)> words;
    const hn::Repartition<int32_t, decltype(bytes)> d;
    constexpr auto kPixels = static_cast<int64_t>(hn::MaxLanes(bytes) / 16);
    // For each channel two pixels as words: the first and the third, the second and the last.
    alignas(16) uint8_t even[16], odd[16];
    for (size_t k = 0; k < 16; ++k) {
      const size_t at = k / 4 + k / 2 % 2 * 2 * kStep;
      even[k] = k % 2 == 0 && k / 4 < kStep ? static_cast<uint8_t>(at) : 255;
      odd[k] = k % 2 == 0 && k / 4 < kStep ? static_cast<uint8_t>(at + kStep) : 255;
    }
    const auto evens = hn::LoadDup128(bytes, even), odds = hn::LoadDup128(bytes, odd);
    const int32_t* const first = first_.data();
    int64_t i = begin_;
    for (; i + kPixels <= end_; i += kPixels) {
      const auto pixels = combined<decltype(part)>(
          bytes, [=](int64_t k) { return hn::LoadU(part, row + first[i + k / 16]); });
      auto sum = hn::Zero(d), other = sum;
      const auto add = [&](auto order, const int32_t* weights) {
        sum = hn::ReorderWidenMulAccumulate(d, hn::BitCast(words, hn::TableLookupBytesOr0(pixels, order)),
                                            hn::BitCast(words, hn::LoadU(d, weights + 4 * i)), sum, other);
      };
      add(evens, even_.data());
      add(odds, odd_.data());
      store_fours(d, hn::RearrangeToOddPlusEven(sum, other), out + i * kStep, kStep);
    }
    return i;
  }

  int64_t planes(const uint8_t* row, int32_t* out) const {
    const Lanes<int32_t> d;
    const hn::RebindToUnsigned<decltype(d)> bits;
    const hn::Repartition<int16_t, decltype(d)> words;
    const auto byte = hn::Set(bits, uint32_t{0x00FF00FF});
    int64_t i = begin_;
    for (; i + kLanes<int32_t> <= end_; i += kLanes<int32_t>) {
      const auto four =
          hn::GatherOffset(bits, reinterpret_cast<const uint32_t*>(row), hn::LoadU(d, first_.data() + i));
      auto sum = hn::Zero(d), other = sum;
      const auto add = [&](auto pixels, const int32_t* weights) {
        sum = hn::ReorderWidenMulAccumulate(d, hn::BitCast(words, hn::And(pixels, byte)),
                                            hn::BitCast(words, hn::LoadU(d, weights)), sum, other);
      };
      add(four, even_.data() + i);
      add(hn::ShiftRight<8>(four), odd_.data() + i);
      hn::StoreU(hn::RearrangeToOddPlusEven(sum, other), d, out + i);
    }
    return i;
  }

  const Axis& axis_;
  const int64_t step_;
  int64_t begin_ = 0, end_ = 0;
  std::vector<int32_t> first_, even_, odd_;
};

// The weighted sum of four rows, divided by 2^22.
void blend(const std::array<const int32_t*, kTaps>& rows, const int64_t* weights, int64_t n, uint8_t* out) {
  std::array<uint32_t, kTaps> by;
  for (size_t k = 0; k < kTaps; ++k) by[k] = static_cast<uint32_t>(weights[k]);
  for_lanes<int32_t, 4>(n, [=](auto d, auto vectors, int64_t i) {
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    const hn::RebindToUnsigned<decltype(d)> bits;  // unsigned: sums may wrap around
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    for (int v = 0; v < vectors; ++v) {
      auto sum = hn::Set(bits, kHalf);
      for (size_t k = 0; k < kTaps; ++k) {
        const auto values = hn::BitCast(bits, hn::LoadU(d, rows[k] + i + v * lanes));
        sum = hn::Add(sum, hn::Mul(values, hn::Set(bits, by[k])));
      }
      hn::StoreU(hn::DemoteTo(bytes, hn::ShiftRight<kBits>(hn::BitCast(d, sum))), bytes, out + i + v * lanes);
    }
  });
}

// Resamples rows of an image, and keeps the last four and their numbers.
class KeptRows {
 public:
  KeptRows(const uint8_t* image, int64_t length, const Across& across, int32_t* memory)
      : image_(image), length_(length), across_(across), memory_(memory) {}

  std::array<const int32_t*, kTaps> get(const int64_t* numbers) {
    std::array<const int32_t*, kTaps> rows;
    for (size_t k = 0; k < kTaps; ++k) {
      const auto has = [&](int64_t number) { return number == numbers[k]; };
      auto place = std::find_if(known_.begin(), known_.end(), has);
      if (place == known_.end()) {
        place = std::find_if(known_.begin(), known_.end(), [&](int64_t number) {
          return std::find(numbers, numbers + kTaps, number) == numbers + kTaps;
        });
        across_(image_ + numbers[k] * length_, row(place));
        *place = numbers[k];
      }
      rows[k] = row(place);
    }
    return rows;
  }

 private:
  using Known = std::array<int64_t, kTaps>;

  int32_t* row(Known::const_iterator place) const {
    return memory_ + (place - known_.begin()) * across_.room();
  }

  const uint8_t* const image_;
  const int64_t length_;
  const Across& across_;
  int32_t* const memory_;
  Known known_{-1, -1, -1, -1};
};

constexpr int64_t kRows = 64;

}  // namespace

void resize_cubic_bytes(const uint8_t* x, int64_t n, int64_t height, int64_t length, const int64_t* rows,
                        int64_t new_height, const int64_t* down, const int64_t* columns, int64_t new_width,
                        const int64_t* across, int64_t step, uint8_t* out) {
  const Axis vertical(rows, down, new_height, height), horizontal(columns, across, new_width, length / step);
  const Across resampling(horizontal, length, step);
  const int64_t blocks = (new_height + kRows - 1) / kRows, values = new_width * step,
                room = kTaps * resampling.room();
  const auto memory = new_lines<int32_t>(room * omp_get_max_threads());
#pragma omp parallel for
  for (int64_t i = 0; i < n * blocks; ++i) {
    const int64_t top = i % blocks * kRows, image = i / blocks;
    KeptRows kept(x + image * height * length, length, resampling,
                  memory.get() + room * omp_get_thread_num());
    for (int64_t y = top; y < std::min(top + kRows, new_height); ++y)
      blend(kept.get(vertical.of(y)), down + y * kTaps, values, out + (image * new_height + y) * values);
  }
}

}  // namespace chiasm::kernels
