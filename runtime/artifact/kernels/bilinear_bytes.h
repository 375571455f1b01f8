// Reads images of bytes at runs of positions, each from 2 x 2 pixels. Positions are rounded to 1/32, so that
// weights are multiples of 1/1024 and sums are exact.
#pragma once

#include <cstring>

#include "places_bytes.h"

namespace chiasm::kernels::bytes {

struct Bilinear : Places {
  // The weights of the second pixel: across in 1/64 * 2^15, for 16-bit products, and down in 1/32; with room
  // for vectors that run over the end.
  int16_t across[kRun + 64], down[kRun + 64];

  static int64_t loaded(int64_t step) { return step == 1 ? 4 : 8; }

  void find(const double* at_x, const double* at_y, int64_t n, const Source& s) {
    quantise(at_x, n, s.width, kScale, s.padding, s.align_corners, x);
    quantise(at_y, n, s.height, kScale, s.padding, s.align_corners, y);
    const Lanes<int32_t> d;
    const hn::Rebind<int16_t, Lanes<int32_t>> words;
    const auto rest = hn::Set(d, kScale - 1);
    for (int64_t i = 0; i < n; i += kLanes<int32_t>) {
      const auto at = hn::LoadU(d, x + i), line = hn::LoadU(d, y + i);
      // inside only if that many bytes can be loaded in the row below
      put(i, hn::ShiftRight<5>(at), hn::ShiftRight<5>(line), s.width - 1, s.height - 1,
          (s.height - 1) * s.row() - s.wide + 1, s);
      hn::StoreU(hn::DemoteTo(words, hn::ShiftLeft<9>(hn::And(at, rest))), words, across + i);
      hn::StoreU(hn::DemoteTo(words, hn::And(line, rest)), words, down + i);
    }
  }

  template <int kStep>
  void read(const uint8_t* image, const Source& s, int64_t n, const uint8_t* fill, uint8_t* out) const {
    for (int64_t i = 0; i < n;) {
      const int64_t last = end(i, n);
      if constexpr (kStep > 0)
        if (inside[i]) i = read_inside<kStep>(image, s.row(), i, last, out);
      for (; i < last; ++i) read_one<kStep>(image, s, i, fill, out + i * s.step);
    }
  }

 private:
  // Any position.
  template <int kStep>
  void read_one(const uint8_t* image, const Source& s, int64_t i, const uint8_t* fill, uint8_t* out) const {
    const int64_t step = kStep > 0 ? kStep : s.step;
    const int64_t column = x[i] >> 5, line = y[i] >> 5;
    const int32_t right = x[i] & 31, below = y[i] & 31;
    if (x[i] <= -kScale || column >= s.width || y[i] <= -kScale || line >= s.height) {
      std::memcpy(out, fill, static_cast<size_t>(step));
      return;
    }
    for (int64_t c = 0; c < step; ++c) {
      const auto pixel = [&](int64_t v, int64_t u) -> int32_t {
        return v < 0 || v >= s.height || u < 0 || u >= s.width ? fill[c] : image[v * s.row() + u * step + c];
      };
      const auto across_row = [&](int64_t v) {
        return pixel(v, column) * (32 - right) + pixel(v, column + 1) * right;
      };
      const int32_t sum = across_row(line) * (32 - below) + across_row(line + 1) * below;
      out[c] = static_cast<uint8_t>((sum + 512) >> 10);
    }
  }

  // Reads positions from i to last, whose pixels are inside; returns how many. The sum 32 a + f (b - a) is
  // taken down and then across. Only the quotient by 32 of the second product, which has 18 bits, is needed:
  // the high half of a product with f * 2^9.
  template <class D>
  HWY_INLINE static hn::Vec<D> down_of(D, hn::Vec<D> a, hn::Vec<D> b, hn::Vec<D> weight) {
    return hn::Add(hn::ShiftLeft<5>(a), hn::Mul(hn::Sub(b, a), weight));
  }
  template <class D>
  HWY_INLINE static hn::Vec<D> across_of(D d, hn::Vec<D> a, hn::Vec<D> b, hn::Vec<D> weight) {
    const auto part = hn::MulHigh(hn::ShiftLeft<2>(hn::Sub(b, a)), weight);
    return hn::ShiftRight<5>(hn::Add(hn::Add(a, part), hn::Set(d, int16_t{16})));
  }

  template <int kStep>
  int64_t read_inside(const uint8_t* image, int64_t row, int64_t i, int64_t last, uint8_t* out) const {
    if constexpr (kStep == 1)
      return read_plane(image, row, i, last, out);
    else
      return read_frame<kStep>(image, row, i, last, out);
  }

  // Loads eight bytes for each pixel, which include the next pixel.
  template <int kStep>
  int64_t read_frame(const uint8_t* image, int64_t row, int64_t i, int64_t last, uint8_t* out) const {
    using Part = hn::FixedTag<uint8_t, 8>;
    const hn::CappedTag<int16_t, 16> d;
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    constexpr auto kPixels = static_cast<int64_t>(hn::MaxLanes(d) / 8);
    alignas(32) uint8_t order[32];  // the pixel's weight, eight times
    for (size_t k = 0; k < 32; ++k) order[k] = static_cast<uint8_t>(k / 16 * 2 + k % 2);
    const hn::Repartition<uint8_t, decltype(d)> weights_bytes;
    const auto indices = hn::Load(weights_bytes, order);
    const auto weight = [=](const int16_t* p) {
      const auto all = hn::LoadDup128(weights_bytes, reinterpret_cast<const uint8_t*>(p));
      return hn::BitCast(d, hn::TableLookupBytes(all, indices));
    };
    const auto load = [=](const uint8_t* from, const int32_t* places) {
      return hn::PromoteTo(
          d, combined<Part>(bytes, [=](int64_t k) { return hn::LoadU(Part(), from + places[k / 8]); }));
    };
    // Four bytes are stored: the next position overwrites the excess one.
    for (; i + kPixels + 1 <= last; i += kPixels) {
      const auto tall = down_of(d, load(image, index + i), load(image + row, index + i), weight(down + i));
      const auto value = across_of(d, tall, hn::ShiftRightLanes<kStep>(d, tall), weight(across + i));
      alignas(16) uint8_t pixels[hn::MaxLanes(bytes)];
      hn::Store(hn::DemoteTo(bytes, value), bytes, pixels);
      for (int64_t k = 0; k < kPixels; ++k) std::memcpy(out + (i + k) * kStep, pixels + 8 * k, 4);
    }
    return i;
  }

  // Loads two bytes for each pixel, in one integer.
  int64_t read_plane(const uint8_t* image, int64_t row, int64_t i, int64_t last, uint8_t* out) const {
    const Lanes<int32_t> integers;
    const hn::RebindToUnsigned<decltype(integers)> d;
    const hn::Repartition<int16_t, decltype(d)> words;
    constexpr int64_t kPixels = kLanes<int32_t>;
    const auto load = [=, this](const uint8_t* from, int64_t at) {
      const auto four =
          hn::GatherOffset(d, reinterpret_cast<const uint32_t*>(from), hn::LoadU(integers, index + at));
      const auto byte = hn::Set(d, uint32_t{255});
      return hn::BitCast(
          words, hn::Or(hn::And(four, byte), hn::ShiftLeft<8>(hn::And(four, hn::ShiftLeft<8>(byte)))));
    };
    const auto weight = [=](const int16_t* p) {
      return hn::BitCast(d, hn::PromoteTo(integers, hn::LoadU(hn::Rebind<int16_t, decltype(integers)>(), p)));
    };
    for (; i + kPixels <= last; i += kPixels) {
      const auto both = weight(down + i);
      const auto tall = down_of(words, load(image, i), load(image + row, i),
                                hn::BitCast(words, hn::Or(both, hn::ShiftLeft<16>(both))));
      const auto next = hn::BitCast(words, hn::ShiftRight<16>(hn::BitCast(d, tall)));
      const auto value = across_of(words, tall, next, hn::BitCast(words, weight(across + i)));
      const auto level = hn::And(hn::BitCast(d, value), hn::Set(d, uint32_t{255}));
      const hn::Rebind<uint8_t, decltype(d)> bytes;
      hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(integers, level)), bytes, out + i);
    }
    return i;
  }
};

}  // namespace chiasm::kernels::bytes
