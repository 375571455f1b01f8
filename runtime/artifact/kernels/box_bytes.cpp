// Means of windows of bytes, and Laplacians: running sums down the columns, and along the rows sums of a few
// shorter sums, so that the time hardly depends on the window's size.
#include "declared/box_bytes.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// Along a row windows have lengths 1, 4, 16, ..., each a sum of 4 of the one before, as far as that pays.
constexpr int64_t kRadix = 4, kMostTerms = 8;

constexpr int64_t lengths_of_windows(int64_t count) {
  int64_t lengths = 1;
  for (int64_t length = 1; count >= kMostTerms * length; length *= kRadix) ++lengths;
  return lengths;
}

template <class Word, class D>
HWY_INLINE hn::Vec<D> bytes_as_words(D d, const uint8_t* p) {
  return hn::PromoteTo(d, hn::LoadU(hn::Rebind<uint8_t, D>(), p));
}

// sums += entering - leaving; either may be null.
template <class Word>
void slide(const uint8_t* entering, const uint8_t* leaving, int64_t n, Word* sums) {
  if (entering != nullptr && leaving != nullptr)
    for_lanes<Word, 2>(n, [=](auto d, auto vectors, int64_t x) {
      const auto lanes = static_cast<int64_t>(hn::Lanes(d));
      for (int v = 0; v < vectors; ++v) {
        const int64_t at = x + v * lanes;
        const auto change =
            hn::Sub(bytes_as_words<Word>(d, entering + at), bytes_as_words<Word>(d, leaving + at));
        hn::StoreU(hn::Add(hn::LoadU(d, sums + at), change), d, sums + at);
      }
    });
  else if (entering != nullptr)
    for_lanes<Word>(n, [=](auto d, auto, int64_t x) {
      hn::StoreU(hn::Add(hn::LoadU(d, sums + x), bytes_as_words<Word>(d, entering + x)), d, sums + x);
    });
  else if (leaving != nullptr)
    for_lanes<Word>(n, [=](auto d, auto, int64_t x) {
      hn::StoreU(hn::Sub(hn::LoadU(d, sums + x), bytes_as_words<Word>(d, leaving + x)), d, sums + x);
    });
}

// out[x] is the sum of x[x + i * apart] for i = 0 .. kRadix - 1.
template <class Word>
void lengthen(const Word* x, int64_t apart, int64_t n, Word* out) {
  for_lanes<Word, 2>(n, [=](auto d, auto vectors, int64_t k) {
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    for (int v = 0; v < vectors; ++v) {
      const Word* const at = x + k + v * lanes;
      const auto load = [=](int64_t i) { return hn::LoadU(d, at + i * apart); };
      hn::StoreU(hn::Add(hn::Add(load(0), load(1)), hn::Add(load(2), load(3))), d, out + k + v * lanes);
    }
  });
}

/** Sums divided by the area, rounded to the nearest byte, half to even. */
template <class Word>
class Mean;

// In 16 bits: (sum + area / 2) / area as a product with a reciprocal that is rounded up, minus one if a half
// was rounded to an odd number.
template <>
class Mean<uint16_t> {
 public:
  explicit Mean(int64_t area)
      : area_(static_cast<uint16_t>(area)), half_(static_cast<uint16_t>(area / 2)), even_(area % 2 == 0) {
    while ((int64_t{2} << shift_) < area) ++shift_;
    reciprocal_ = static_cast<uint16_t>((int64_t{65536} << shift_) / area + 1);
  }

  // Whether the sums fit, and the reciprocal's error does not reach the next integer.
  static bool is_exact(int64_t area) {
    if (area < 2 || area > 256) return false;
    const int64_t one = int64_t{65536} << Mean(area).shift_;
    return (255 * area + area / 2) * (Mean(area).reciprocal_ * area - one) < one;
  }

  template <class D>
  HWY_INLINE auto operator()(D d, hn::Vec<D> sum, const uint8_t* /*centre*/) const {
    const auto up = hn::Add(sum, hn::Set(d, half_));
    auto mean = hn::ShiftRightSame(hn::MulHigh(up, hn::Set(d, reciprocal_)), shift_);
    const auto whole = hn::VecFromMask(d, hn::Eq(hn::Mul(mean, hn::Set(d, area_)), up));
    mean = hn::Sub(mean, hn::And(hn::And(mean, whole), hn::Set(d, uint16_t{even_})));
    return hn::DemoteTo(hn::Rebind<uint8_t, D>(), hn::BitCast(hn::RebindToSigned<D>(), mean));
  }

 private:
  uint16_t area_, half_, reciprocal_;
  bool even_;
  int shift_ = 0;
};

// In 32 bits: quotients in float32. Only a true half may be rounded to a half. With an odd area there are no
// halves; with a small area all other quotients are further from a half than the error of a product with the
// reciprocal.
template <>
class Mean<uint32_t> {
 public:
  explicit Mean(int64_t area)
      : area_(static_cast<float>(area)), reciprocal_(1 / area_), divides_(area % 2 == 0 || area > 8191) {}

  template <class D>
  HWY_INLINE auto operator()(D, hn::Vec<D> sum, const uint8_t* /*centre*/) const {
    const hn::Rebind<float, D> floats;
    const auto value = hn::ConvertTo(floats, hn::BitCast(hn::RebindToSigned<D>(), sum));
    const auto mean =
        divides_ ? hn::Div(value, hn::Set(floats, area_)) : hn::Mul(value, hn::Set(floats, reciprocal_));
    return hn::DemoteTo(hn::Rebind<uint8_t, D>(), hn::NearestInt(mean));
  }

 private:
  float area_, reciprocal_;
  bool divides_;
};

/** Sums minus the area times the centre, in 16 bits, which hold it up to an area of 129. */
class Laplacian {
 public:
  explicit Laplacian(int64_t area) : area_(static_cast<uint16_t>(area)) {}

  template <class D>
  HWY_INLINE auto operator()(D d, hn::Vec<D> sum, const uint8_t* centre) const {
    const auto all = hn::Mul(bytes_as_words<uint16_t>(d, centre), hn::Set(d, area_));
    return hn::BitCast(hn::RebindToSigned<D>(), hn::Sub(sum, all));
  }

 private:
  uint16_t area_;
};

// out = result(sum of the terms, centre)
template <class Word, class Result, class Out>
void add_up(const Word* const* terms, int64_t count, const Result& result, const uint8_t* centre, int64_t n,
            Out* out) {
  for_lanes<Word, 4>(n, [=](auto d, auto vectors, int64_t x) {
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    hn::Vec<decltype(d)> sum[vectors];
    for (int v = 0; v < vectors; ++v) sum[v] = hn::LoadU(d, terms[0] + x + v * lanes);
    for (int64_t i = 1; i < count; ++i)
      for (int v = 0; v < vectors; ++v) sum[v] = hn::Add(sum[v], hn::LoadU(d, terms[i] + x + v * lanes));
    for (int v = 0; v < vectors; ++v) {
      const int64_t at = x + v * lanes;
      hn::StoreU(result(d, sum[v], centre + at), hn::Rebind<Out, decltype(d)>(), out + at);
    }
  });
}

// result(sum of the window, centre) of every pixel.
template <class Word, class Result, class Out>
void over_windows(const uint8_t* x, const Planes& planes, int64_t ky, int64_t kx, Border border,
                  const Result& result, Out* out) {
  const int64_t height = planes.height, width = planes.width, step = planes.step;
  const int64_t above = (ky - 1) / 2, before = (kx - 1) / 2 * step, reach = kx / 2 * step;
  const int64_t levels = lengths_of_windows(kx), lead = whole_lines<Word>(reach);
  // Each tile sums the rows above it again, so tiles are taller than the window.
  const int64_t most_rows = std::max(kTileRows, 4 * ky);
  for_tiles<Word>(
      planes, ky / static_cast<int64_t>(sizeof(Word)) + levels + 1, levels, lead + reach, border,
      [&](const Tile& tile, Word* scratch, int64_t length) {
        const uint8_t* const image = x + tile.plane * height * width;
        const Span span(tile, width, reach, reach);
        Word *const sums = scratch + lead, *const inner = sums + span.first - tile.left;
        const auto row = [&](int64_t y) -> const uint8_t* {
          const int64_t source = inside(y, height, border);
          return source < 0 ? nullptr : image + source * width + span.first;
        };
        // The width is a sum of lengths 1, 4, 16, ..., by its digits in base 4.
        const Word* terms[2 * kMostTerms + 3 * 8];
        int64_t count = 0;
        int64_t at = -before, window = 1;
        for (int64_t i = 1; i < levels; ++i) window *= kRadix;
        for (int64_t i = levels - 1, left = kx; i >= 0; --i, window /= kRadix)
          for (; left >= window; left -= window, at += window * step) terms[count++] = sums + i * length + at;
        std::fill_n(inner, span.count(), Word{0});
        for (int64_t i = 0; i + 1 < ky; ++i)
          slide<Word>(row(tile.top - above + i), nullptr, span.count(), inner);
        const uint8_t* leaving = nullptr;
        for (int64_t y = tile.top; y < tile.bottom; ++y) {
          slide(row(y - above + ky - 1), leaving, span.count(), inner);
          leaving = row(y - above);
          extend(sums, tile, width, reach, reach, border, Word{0}, step);
          const int64_t columns = tile.right - tile.left;
          int64_t size = 1;
          for (int64_t i = 1; i < levels; ++i, size *= kRadix)
            lengthen(sums + (i - 1) * length - before, size * step, columns + (kx - kRadix * size) * step,
                     sums + i * length - before);
          add_up(terms, count, result, tile_row(image, planes, tile, y), columns,
                 tile_row(out + tile.plane * height * width, planes, tile, y));
        }
      },
      most_rows);
}

}  // namespace

void box_bytes(const uint8_t* x, int64_t n, int64_t height, int64_t width, int64_t ky, int64_t kx,
               int64_t step, Border border, uint8_t* out) {
  const Planes planes{n, height, width, step};
  if (Mean<uint16_t>::is_exact(ky * kx))
    over_windows<uint16_t>(x, planes, ky, kx, border, Mean<uint16_t>(ky * kx), out);
  else
    over_windows<uint32_t>(x, planes, ky, kx, border, Mean<uint32_t>(ky * kx), out);
}

void laplacian_bytes(const uint8_t* x, int64_t n, int64_t height, int64_t width, int64_t ky, int64_t kx,
                     int64_t step, Border border, int16_t* out) {
  over_windows<uint16_t>(x, {n, height, width, step}, ky, kx, border, Laplacian(ky * kx), out);
}

}  // namespace chiasm::kernels
