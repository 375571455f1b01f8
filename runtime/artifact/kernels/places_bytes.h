// Where images of integers are read at runs of positions; and reading them at the nearest pixels.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "positions.h"

namespace chiasm::kernels::bytes {

constexpr int32_t kScale = 32;          // positions between pixels are rounded to 1/kScale
constexpr int32_t kFurthest = 1 << 24;  // in pixels: the limit of positions

// The images that are read. A pixel has `step` values. At any pixel that counts as inside, `wide` values can
// be loaded (the taps' loaded() says how many).
struct Source {
  int64_t height, width, step, wide;
  Padding padding;
  bool align_corners;
  int64_t row() const { return width * step; }
};

// Mirrors a position in 1/scale pixel at the corner pixels' centres or at the outer edges.
inline int64_t folded(int64_t at, int64_t size, int32_t scale, bool align_corners) {
  // in halves of 1/scale, because the edge may lie between two multiples
  const int64_t low = align_corners ? 0 : scale, period = 4 * scale * (align_corners ? size - 1 : size);
  if (period == 0) return 0;
  const int64_t turned = ((2 * at + low) % period + period) % period;
  const int64_t inside = (std::min(turned, period - turned) - low) / 2;
  return std::clamp<int64_t>(inside, 0, scale * (size - 1));
}

// Positions along an axis in units of 1/scale pixel, rounded half to even, limited to `least` and `greatest`;
// NaN becomes `unknown`. Runs have room for whole vectors.
inline void limited_steps(const double* x, int64_t n, int32_t scale, double least, double greatest,
                          double unknown, int32_t* out) {
  const Lanes<double> d;
  const auto low = hn::Set(d, least), high = hn::Set(d, greatest), none = hn::Set(d, unknown),
             steps = hn::Set(d, static_cast<double>(scale));
  for (int64_t i = 0; i < n; i += kLanes<double>) {
    const auto at = hn::Mul(hn::LoadU(d, x + i), steps);
    const auto limited = hn::IfThenElse(hn::Eq(at, at), smaller(larger(at, low), high), none);
    hn::StoreU(truncated(d, hn::Round(limited)), Integers<Lanes<double>>(), out + i);
  }
}

// The same, moved into the image if the padding requires it. NaN is outside.
inline void quantise(const double* x, int64_t n, int64_t size, int32_t scale, Padding padding,
                     bool align_corners, int32_t* out) {
  const double last = static_cast<double>(scale * (size - 1)), all = scale;
  const bool zeros = padding == Padding::kZeros, edge = padding == Padding::kBorder;
  const double least = zeros  ? -all
                       : edge ? 0
                              : -all * kFurthest,
               greatest = zeros  ? last + all
                          : edge ? last
                                 : all * kFurthest;
  limited_steps(x, n, scale, least, greatest, -all, out);
  if (padding != Padding::kReflection) return;
  for (int64_t i = 0; i < n; ++i)
    if (x[i] == x[i] && (out[i] < 0 || out[i] > last))
      out[i] = static_cast<int32_t>(folded(out[i], size, scale, align_corners));
}

// A run of positions: the place of the first pixel to read for each, and whether its pixels are inside.
struct Places {
  int32_t x[kRun], y[kRun], index[kRun];
  uint8_t inside[kRun];

  // The end of the stretch from i on in which all positions are inside, or all are outside.
  int64_t end(int64_t i, int64_t n) const {
    const void* const other = std::memchr(inside + i, inside[i] ? 0 : 1, static_cast<size_t>(n - i));
    return other == nullptr ? n : static_cast<const uint8_t*>(other) - inside;
  }

  // Stores a vector of pixels. Pixels are inside if their column is below `columns`, their line below
  // `lines`, and their place below `limit`.
  HWY_INLINE void put(int64_t i, hn::Vec<Lanes<int32_t>> column, hn::Vec<Lanes<int32_t>> line,
                      int64_t columns, int64_t lines, int64_t limit, const Source& s) {
    const Lanes<int32_t> d;
    const hn::Rebind<uint8_t, Lanes<int32_t>> bytes;
    const auto whole = [=](int64_t value) { return hn::Set(d, static_cast<int32_t>(value)); };
    const auto none = hn::Set(d, -1);
    const auto near = hn::And(hn::And(hn::Gt(column, none), hn::Lt(column, whole(columns))),
                              hn::And(hn::Gt(line, none), hn::Lt(line, whole(lines))));
    const auto place =
        hn::IfThenElseZero(near, hn::Add(hn::Mul(line, whole(s.row())), hn::Mul(column, whole(s.step))));
    const auto in = hn::And(near, hn::Lt(place, whole(limit)));
    hn::StoreU(place, d, index + i);
    hn::StoreU(hn::DemoteTo(bytes, hn::IfThenElseZero(in, whole(1))), bytes, inside + i);
  }

  // The offset from `index` to pixels that the next row of positions reads and this one does not.
  static int64_t ahead(const Source&) { return 0; }
};

struct Nearest : Places {
  static int64_t loaded(int64_t step) { return step == 3 ? 4 : step; }

  void find(const double* at_x, const double* at_y, int64_t n, const Source& s) {
    quantise(at_x, n, s.width, 1, s.padding, s.align_corners, x);
    quantise(at_y, n, s.height, 1, s.padding, s.align_corners, y);
    for (int64_t i = 0; i < n; i += kLanes<int32_t>) {
      const Lanes<int32_t> d;
      // inside only if that many values can be loaded
      put(i, hn::LoadU(d, x + i), hn::LoadU(d, y + i), s.width, s.height, s.height * s.row() - s.wide + 1, s);
    }
  }

  template <int kStep, class Pixel>
  void read(const Pixel* image, const Source& s, int64_t n, const Pixel* fill, Pixel* out) const {
    const int64_t step = kStep > 0 ? kStep : s.step;
    const auto copy = [=](int64_t i, int64_t from, int64_t values) {
      std::memcpy(out + i * step, image + from, sizeof(Pixel) * static_cast<size_t>(values));
    };
    for (int64_t i = 0; i < n;) {
      const int64_t last = end(i, n);
      if (inside[i]) {
        if constexpr (kStep == 3)  // the next position overwrites the excess value
          for (; i + 1 < last; ++i) copy(i, index[i], 4);
        for (; i < last; ++i) copy(i, index[i], step);
      }
      for (; i < last; ++i)
        if (x[i] >= 0 && x[i] < s.width && y[i] >= 0 && y[i] < s.height)
          copy(i, y[i] * s.row() + x[i] * step, step);
        else
          std::copy_n(fill, step, out + i * step);
    }
  }
};

}  // namespace chiasm::kernels::bytes
