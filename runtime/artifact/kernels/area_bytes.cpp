// Resizing of bytes by areas: the mean of the area that each pixel of the output covers, exact before
// rounding.
#include <bit>
#include <cstring>

#include "declared/area_bytes.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

using Word = uint16_t;

// The largest window whose sums fit into 16 bits.
constexpr int64_t kSmall = 257;

// Sums of ky x kx pixels for one row of windows, at every value at which a window may begin.
void sums_of_windows(const uint8_t* x, int64_t stride, int64_t ky, int64_t kx, int64_t step, int64_t values,
                     Word* down, Word* sums) {
  for_lanes<Word>(values, [=](auto d, auto, int64_t k) {
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    auto sum = hn::Zero(d);
    for (int64_t y = 0; y < ky; ++y)
      sum = hn::Add(sum, hn::PromoteTo(d, hn::LoadU(bytes, x + y * stride + k)));
    hn::StoreU(sum, d, down + k);
  });
  for_lanes<Word>(values - (kx - 1) * step, [=](auto d, auto, int64_t k) {
    auto sum = hn::LoadU(d, down + k);
    for (int64_t i = 1; i < kx; ++i) sum = hn::Add(sum, hn::LoadU(d, down + k + i * step));
    hn::StoreU(sum, d, sums + k);
  });
}

// Means of windows, rounded half up, at every value; `area` is a power of two.
void shifted(const Word* sums, int64_t area, int64_t values, uint8_t* means) {
  const int by = std::countr_zero(static_cast<uint64_t>(area));
  const auto half = static_cast<Word>(area / 2);
  for_lanes<Word>(values, [=](auto d, auto, int64_t k) {
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    const hn::RebindToSigned<decltype(d)> integers;
    const auto mean = hn::ShiftRightSame(hn::Add(hn::LoadU(d, sums + k), hn::Set(d, half)), by);
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(integers, mean)), bytes, means + k);
  });
}

// Every kx-th pixel.
template <class Step>
void picked(const uint8_t* x, int64_t kx, Step step, int64_t width, uint8_t* out) {
  for (int64_t i = 0; i < width; ++i)
    std::memcpy(out + i * step, x + i * kx * step, static_cast<size_t>(int64_t{step}));
}

void whole_windows(const uint8_t* x, int64_t n, int64_t height, int64_t width, int64_t new_height,
                   int64_t new_width, int64_t step, uint8_t* out) {
  const int64_t ky = height / new_height, kx = width / step / new_width, area = ky * kx;
  const int64_t ends = width - (kx - 1) * step;
  const bool is_power = std::has_single_bit(static_cast<uint64_t>(area));
  const int64_t room = whole_lines<Word>(width);
  const auto memory = new_lines<Word>(3 * room * omp_get_max_threads());
  // The bias keeps integer quotients from falling below their value by float32's rounding error.
  const float scale = 1.0f / static_cast<float>(2 * area), bias = static_cast<float>(area) + 0.5f;
#pragma omp parallel for
  for (int64_t i = 0; i < n * new_height; ++i) {
    Word* const down = memory.get() + 3 * room * omp_get_thread_num();
    Word* const sums = down + room;
    auto* const means = reinterpret_cast<uint8_t*>(sums + room);
    uint8_t* const row = out + i * new_width * step;
    sums_of_windows(x + i * ky * width, width, ky, kx, step, width, down, sums);
    if (!is_power) {
      for (int64_t k = 0; k < new_width; ++k)
        for (int64_t c = 0; c < step; ++c)
          row[k * step + c] =
              static_cast<uint8_t>((2 * static_cast<float>(sums[k * kx * step + c]) + bias) * scale);
      continue;
    }
    shifted(sums, area, ends, means);
    switch (step) {
      case 1: picked(means, kx, std::integral_constant<int64_t, 1>(), new_width, row); break;
      case 3: picked(means, kx, std::integral_constant<int64_t, 3>(), new_width, row); break;
      case 4: picked(means, kx, std::integral_constant<int64_t, 4>(), new_width, row); break;
      default: picked(means, kx, step, new_width, row);
    }
  }
}

// Along an axis: the pixels that each pixel of the output covers, and how much of each, in units of 1 / out.
struct Covered {
  int64_t each;
  std::vector<int64_t> first;
  std::vector<uint32_t> parts;

  Covered(int64_t in, int64_t out) : each((in + out - 1) / out + 1), first(static_cast<size_t>(out)) {
    parts.resize(static_cast<size_t>(each * out));
    for (int64_t i = 0; i < out; ++i) {
      const int64_t begin = i * in / out;
      first[static_cast<size_t>(i)] = begin;
      for (int64_t k = 0; k < each; ++k) {
        const int64_t pixel = begin + k;
        const int64_t part = std::min((pixel + 1) * out, (i + 1) * in) - std::max(pixel * out, i * in);
        parts[static_cast<size_t>(i * each + k)] = static_cast<uint32_t>(std::max<int64_t>(part, 0));
      }
    }
  }
};

void parts_of_windows(const uint8_t* x, int64_t n, int64_t height, int64_t width, int64_t new_height,
                      int64_t new_width, int64_t step, uint8_t* out) {
  const int64_t columns = width / step;
  const Covered down(height, new_height), across(columns, new_width);
  const int64_t room = whole_lines<uint32_t>(width);
  const auto memory = new_lines<uint32_t>(room * omp_get_max_threads());
  const double area = static_cast<double>(height) * static_cast<double>(columns);
  const double scale = 1 / (2 * area), bias = area + 0.5;
#pragma omp parallel for
  for (int64_t i = 0; i < n * new_height; ++i) {
    uint32_t* const sums = memory.get() + room * omp_get_thread_num();
    const int64_t y = i % new_height;
    const uint8_t* const from = x + (i / new_height * height + down.first[static_cast<size_t>(y)]) * width;
    for (int64_t r = 0; r < down.each; ++r) {
      const uint32_t part = down.parts[static_cast<size_t>(y * down.each + r)];
      if (part == 0) {
        if (r > 0) continue;
        std::fill_n(sums, width, 0u);
        continue;
      }
      const uint8_t* const row = from + r * width;
      const bool first = r == 0;
      for_lanes<uint32_t, 2>(width, [=](auto d, auto vectors, int64_t k) {
        const hn::Rebind<uint8_t, decltype(d)> bytes;
        const auto lanes = static_cast<int64_t>(hn::Lanes(d));
        for (int v = 0; v < vectors; ++v) {
          const int64_t at = k + v * lanes;
          const auto product = hn::Mul(hn::PromoteTo(d, hn::LoadU(bytes, row + at)), hn::Set(d, part));
          hn::StoreU(first ? product : hn::Add(hn::LoadU(d, sums + at), product), d, sums + at);
        }
      });
    }
    uint8_t* const row = out + i * new_width * step;
    for (int64_t k = 0; k < new_width; ++k) {
      const uint32_t* const parts = across.parts.data() + k * across.each;
      const uint32_t* const at = sums + across.first[static_cast<size_t>(k)] * step;
      for (int64_t c = 0; c < step; ++c) {
        uint64_t sum = 0;
        for (int64_t p = 0; p < across.each && parts[p] != 0; ++p)
          sum += uint64_t{parts[p]} * at[p * step + c];
        row[k * step + c] = static_cast<uint8_t>((2 * static_cast<double>(sum) + bias) * scale);
      }
    }
  }
}

}  // namespace

void area_bytes(const uint8_t* x, int64_t n, int64_t height, int64_t width, int64_t new_height,
                int64_t new_width, int64_t step, uint8_t* out) {
  const int64_t pixels = width / step;
  const bool whole = height % new_height == 0 && pixels % new_width == 0 && height / new_height <= kSmall &&
                     pixels / new_width <= kSmall && height / new_height * (pixels / new_width) <= kSmall;
  (whole ? whole_windows : parts_of_windows)(x, n, height, width, new_height, new_width, step, out);
}

}  // namespace chiasm::kernels
