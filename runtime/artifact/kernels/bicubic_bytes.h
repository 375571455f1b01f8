// Reads images of bytes at runs of positions from 4 x 4 pixels, by the kernel of bicubic.h. Positions are
// rounded to 1/32, so that weights are multiples of 1/2^34 and sums are exact.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>

#include "places_bytes.h"

namespace chiasm::kernels::bytes {

// Weights of the four pixels along an axis around a position, by Keys' kernel with a = -0.75 (bicubic.h), for
// each fraction of 1/32, in units of 1/2^17.
struct CubicWeights {
  // In two parts, `high` in units of 1/2^10 and `low` in units of 1/2^17, as words: those of the first and
  // the third pixel, and those of the second and the last.
  struct Words {
    int32_t high[2], low[2];
  };
  alignas(64) int32_t whole[kScale][4];
  alignas(64) Words words[kScale];

  constexpr CubicWeights() : whole{}, words{} {
    const auto near = [](int32_t d) { return (5 * d - 288) * d * d + 131072; };
    const auto far = [](int32_t d) { return ((480 - 3 * d) * d - 24576) * d + 393216; };
    const auto pair = [](int32_t first, int32_t second) { return (first & 0xFFFF) + second * 65536; };
    for (int32_t t = 0; t < kScale; ++t) {
      int32_t* const w = whole[t];
      w[0] = far(kScale + t), w[1] = near(t), w[2] = near(kScale - t), w[3] = far(2 * kScale - t);
      for (int k = 0; k < 2; ++k) {
        words[t].high[k] = pair(w[k] >> kLow, w[k + 2] >> kLow);
        words[t].low[k] = pair(w[k] & kRest, w[k + 2] & kRest);
      }
    }
  }

  static constexpr int kLow = 7;
  static constexpr int32_t kRest = (1 << kLow) - 1;
};
constexpr CubicWeights kCubic;

// The shuffle of a row's bytes to words of two pixels, extended by zeros: pairs (p0, p2) four times, then
// (p1, p3) four times.
struct Order {
  alignas(16) uint8_t bytes[2][16];

  template <class Place>
  static constexpr Order made(const Place& place) {
    Order order{};
    for (int lane = 0; lane < 4; ++lane)
      for (int k = 0; k < 4; ++k) {
        uint8_t* const word = order.bytes[k % 2] + 4 * lane + k / 2 * 2;
        word[0] = static_cast<uint8_t>(place(lane, k)), word[1] = 255;
      }
    return order;
  }

  // For four channels of pixels of `step` bytes.
  static constexpr Order of_channels(int step) {
    return made([=](int lane, int pixel) { return pixel * step + lane; });
  }
  // For four positions with four pixels each.
  static constexpr Order of_positions() {
    return made([](int lane, int pixel) { return 4 * lane + pixel; });
  }
};

struct Bicubic : Places {
  static constexpr int32_t kUnknown = INT32_MIN;

  static int64_t loaded(int64_t step) { return step == 1 ? 4 : 16; }

  void find(const double* at_x, const double* at_y, int64_t n, const Source& s) {
    find_axis(at_x, n, s.width, s.padding, x);
    find_axis(at_y, n, s.height, s.padding, y);
    const Lanes<int32_t> d;
    const auto one = hn::Set(d, 1);
    for (int64_t i = 0; i < n; i += kLanes<int32_t>)
      // inside only if that many bytes can be loaded three rows below
      put(i, hn::Sub(hn::ShiftRight<5>(hn::LoadU(d, x + i)), one),
          hn::Sub(hn::ShiftRight<5>(hn::LoadU(d, y + i)), one), s.width - 3, s.height - 3,
          (s.height - 3) * s.row() - s.wide + 1, s);
  }

  static int64_t ahead(const Source& s) { return s.height > 3 ? 3 * s.row() : 0; }

  template <int kStep>
  void read(const uint8_t* image, const Source& s, int64_t n, const uint8_t* fill, uint8_t* out) const {
    for (int64_t i = 0; i < n;) {
      const int64_t last = end(i, n);
      if (inside[i]) {
        if constexpr (kStep == 1)
          for (; i + 4 <= last; i += 4) read_plane(image, s.row(), i, out + i);
        else if constexpr (kStep > 1)
          for (; i < last; ++i) {
            uint8_t made[4];
            read_pixel<kStep>(image + index[i], s.row(), i, made);
            if (i + 1 < n)  // NOLINT(bugprone-branch-clone): the same for four channels alone
              std::memcpy(out + i * kStep, made, 4);  // the next position overwrites the excess byte
            else
              std::memcpy(out + i * kStep, made, kStep);
          }
      }
      for (; i < last; ++i) read_one<kStep>(image, s, i, fill, out + i * s.step);
    }
  }

 private:
  // More than three pixels outside, results no longer change, unless positions are mirrored.
  static void find_axis(const double* at, int64_t n, int64_t size, Padding padding, int32_t* out) {
    const bool mirrored = padding == Padding::kReflection;
    limited_steps(at, n, kScale, kScale * (mirrored ? -double{kFurthest} : -4.0),
                  kScale * (mirrored ? double{kFurthest} : static_cast<double>(size + 3)), kUnknown, out);
  }

  // The indices of four pixels along an axis, -1 for pixels that do not exist.
  static std::array<int64_t, 4> pixels_read(int32_t at, int64_t size, const Source& s) {
    std::array<int64_t, 4> numbers;
    for (int32_t k = 0; k < 4; ++k) {
      const int32_t i = (at >> 5) - 1 + k;
      const bool there = i >= 0 && i < size;
      numbers[static_cast<size_t>(k)] = there                           ? i
                                        : s.padding == Padding::kZeros  ? -1
                                        : s.padding == Padding::kBorder ? std::clamp<int64_t>(i, 0, size - 1)
                                                                        : folded(i, size, 1, s.align_corners);
    }
    return numbers;
  }

  // Any position.
  template <int kStep>
  void read_one(const uint8_t* image, const Source& s, int64_t i, const uint8_t* fill, uint8_t* out) const {
    const auto step = static_cast<size_t>(kStep > 0 ? kStep : s.step);
    const auto is_pixel = [](int64_t number) { return number >= 0; };
    const bool known = x[i] != kUnknown && y[i] != kUnknown;
    const auto columns = pixels_read(x[i], s.width, s), lines = pixels_read(y[i], s.height, s);
    if (!known || std::none_of(columns.begin(), columns.end(), is_pixel) ||
        std::none_of(lines.begin(), lines.end(), is_pixel)) {
      std::memcpy(out, fill, step);
      return;
    }
    if constexpr (kStep > 1) {
      // Gathers the pixels into one block, and reads them like adjacent ones.
      alignas(16) uint8_t pixels[4][16] = {}, made[4];
      for (size_t j = 0; j < 4; ++j)
        for (size_t k = 0; k < 4; ++k) {
          const bool there = is_pixel(lines[j]) && is_pixel(columns[k]);
          const uint8_t* const from = there ? image + lines[j] * s.row() + columns[k] * kStep : fill;
          std::memcpy(pixels[j] + k * kStep, from, kStep);
        }
      read_pixel<kStep>(pixels[0], 16, i, made);
      std::memcpy(out, made, kStep);
      return;
    }
    const int32_t *const across = kCubic.whole[x[i] & 31], *const down = kCubic.whole[y[i] & 31];
    for (size_t c = 0; c < step; ++c) {
      int64_t sum = int64_t{1} << 33;
      for (size_t j = 0; j < 4; ++j) {
        int64_t along = 0;
        for (size_t k = 0; k < 4; ++k) {
          const bool there = is_pixel(lines[j]) && is_pixel(columns[k]);
          along +=
              int64_t{across[k]} * (there ? image[lines[j] * s.row() + columns[k] * s.step + c] : fill[c]);
        }
        sum += down[j] * along;
      }
      out[c] = static_cast<uint8_t>(std::clamp<int64_t>(sum >> 34, 0, 255));
    }
  }

  using Bytes = hn::CappedTag<uint8_t, 32>;  // one row of 16 bytes, or two
  using Quads = hn::Repartition<int32_t, Bytes>;
  using Doubles = hn::CappedTag<double, 4>;
  static constexpr int kRowsAtOnce = static_cast<int>(hn::MaxLanes(Bytes()) / 16);

  // Four sums of 4 x 4 pixels, rounded, as bytes. load(j) returns the bytes of row j, and of the next row if
  // the vector has room for two; `order` picks the words of two pixels from them, four times. across(k)
  // returns the k-th pair of weights of either part, and down(j, part) the weights of row j.
  template <class Load, class Across, class Down>
  HWY_INLINE static void sum_rows(const uint8_t (&order)[2][16], const Load& load, const Across& across,
                                  const Down& down, uint8_t* out) {
    const Bytes bytes;
    const Quads quads;
    const hn::Repartition<int16_t, Bytes> words;
    const auto first = hn::LoadDup128(bytes, order[0]), second = hn::LoadDup128(bytes, order[1]);
    alignas(32) int32_t sums[4][4];
    for (int j = 0; j < 4; j += kRowsAtOnce) {
      const auto row = load(bytes, j);
      const auto even = hn::BitCast(words, hn::TableLookupBytesOr0(row, first)),
                 odd = hn::BitCast(words, hn::TableLookupBytesOr0(row, second));
      const auto sum = [&](int part) {
        auto total = hn::Zero(quads), other = total;
        total = hn::ReorderWidenMulAccumulate(quads, even, across(words, part, 0), total, other);
        total = hn::ReorderWidenMulAccumulate(quads, odd, across(words, part, 1), total, other);
        return hn::RearrangeToOddPlusEven(total, other);
      };
      hn::Store(hn::Add(hn::ShiftLeft<CubicWeights::kLow>(sum(0)), sum(1)), quads, sums[j]);
    }
    const Doubles d;
    const hn::Rebind<int32_t, Doubles> integers;
    const hn::Rebind<uint8_t, Doubles> levels;
    for (int64_t c = 0; c < 4; c += static_cast<int64_t>(hn::MaxLanes(d))) {
      const auto row = [&](int j) { return hn::PromoteTo(d, hn::LoadU(integers, sums[j] + c)); };
      auto total = hn::Mul(row(0), down(d, 0, c));
      for (int j = 1; j < 4; ++j) total = hn::MulAdd(row(j), down(d, j, c), total);  // exact
      const auto level = hn::MulAdd(total, hn::Set(d, 1.0 / 17179869184.0), hn::Set(d, 0.5));
      const auto limited = hn::Min(hn::Max(level, hn::Zero(d)), hn::Set(d, 255.5));
      hn::StoreU(hn::DemoteTo(levels, truncated(d, limited)), levels, out + c);
    }
  }

  // The channels of one position, from 4 x 4 pixels.
  template <int kStep>
  void read_pixel(const uint8_t* from, int64_t row, int64_t i, uint8_t* out) const {
    alignas(16) static constexpr Order kOrder = Order::of_channels(kStep);
    const auto& words_of = kCubic.words[x[i] & 31];
    const int32_t* const weights = kCubic.whole[y[i] & 31];
    sum_rows(
        kOrder.bytes,
        [=](auto bytes, int j) {
          const hn::FixedTag<uint8_t, 16> part;
          return combined<decltype(part)>(
              bytes, [=](int64_t k) { return hn::LoadU(part, from + (j + k / 16) * row); });
        },
        [&](auto words, int part, int k) {
          return hn::BitCast(words, hn::Set(Quads(), (part == 0 ? words_of.high : words_of.low)[k]));
        },
        [=](auto d, int j, int64_t) { return hn::Set(d, static_cast<double>(weights[j])); }, out);
  }

  // One channel at four positions.
  void read_plane(const uint8_t* image, int64_t row, int64_t i, uint8_t* out) const {
    alignas(16) static constexpr Order kOrder = Order::of_positions();
    // The weights of the four positions, next to each other.
    alignas(32) int32_t across[2][2][4], down[4][4];
    for (int p = 0; p < 4; ++p) {
      const auto& words_of = kCubic.words[x[i + p] & 31];
      const int32_t* const weights = kCubic.whole[y[i + p] & 31];
      for (int k = 0; k < 2; ++k) across[0][k][p] = words_of.high[k], across[1][k][p] = words_of.low[k];
      for (int j = 0; j < 4; ++j) down[j][p] = weights[j];
    }
    const int32_t* const places = index + i;
    sum_rows(
        kOrder.bytes,
        [=](auto bytes, int j) {
          const hn::FixedTag<uint8_t, 4> part;
          return combined<decltype(part)>(bytes, [=](int64_t k) {
            return hn::LoadU(part, image + places[k / 4 % 4] + (j + k / 16) * row);
          });
        },
        [&](auto words, int part, int k) {
          return hn::BitCast(words, hn::LoadDup128(Quads(), across[part][k]));
        },
        [&](auto d, int j, int64_t c) {
          return hn::PromoteTo(d, hn::LoadU(hn::Rebind<int32_t, decltype(d)>(), down[j] + c));
        },
        out);
  }
};

}  // namespace chiasm::kernels::bytes
