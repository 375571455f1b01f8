// Levels of pyramids of bytes: the binomial window 1, 4, 6, 4, 1 along both axes, at every other pixel, or
// over pixels with zeros between them. Sums fit into 16 bits: at most 256 * 255 and a half.
#include <cstring>

#include "declared/pyramids.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

using Word = uint16_t;

template <class D>
HWY_INLINE hn::Vec<D> words(D d, const uint8_t* p) {
  return hn::PromoteTo(d, hn::LoadU(hn::Rebind<uint8_t, D>(), p));
}

template <class D>
HWY_INLINE void store_bytes(D, hn::Vec<D> value, uint8_t* out) {
  const hn::Rebind<uint8_t, D> bytes;
  hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(hn::RebindToSigned<D>(), value)), bytes, out);
}

// 1, 4, 6, 4, 1.
template <class D>
HWY_INLINE hn::Vec<D> binomial(D, hn::Vec<D> a, hn::Vec<D> b, hn::Vec<D> c, hn::Vec<D> d, hn::Vec<D> e) {
  const auto inner = hn::Add(hn::Add(b, d), c);  // and 2 c
  return hn::Add(hn::Add(a, e), hn::Add(hn::ShiftLeft<2>(inner), hn::Add(c, c)));
}

// out[x] = the window of the rows.
void weigh_down(const uint8_t* const* rows, int64_t n, Word* out) {
  const uint8_t *const a = rows[0], *const b = rows[1], *const c = rows[2], *const e = rows[3],
                       *const f = rows[4];
  for_lanes<Word, 2>(n, [=](auto d, auto vectors, int64_t x) {
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    for (int v = 0; v < vectors; ++v) {
      const int64_t at = x + v * lanes;
      hn::StoreU(binomial(d, words(d, a + at), words(d, b + at), words(d, c + at), words(d, e + at),
                          words(d, f + at)),
                 d, out + at);
    }
  });
}

// out[x] = the window of x[x + k * step] / 256, rounded half up.
void weigh_along(const Word* x, int64_t step, int64_t n, uint8_t* out) {
  for_lanes<Word, 2>(n, [=](auto d, auto vectors, int64_t k) {
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    for (int v = 0; v < vectors; ++v) {
      const Word* const at = x + k + v * lanes;
      const auto load = [=](int64_t i) { return hn::LoadU(d, at + i * step); };
      const auto sum = binomial(d, load(-2), load(-1), load(0), load(1), load(2));
      store_bytes(d, hn::ShiftRight<8>(hn::Add(sum, hn::Set(d, Word{128}))), out + k + v * lanes);
    }
  });
}

// Every other pixel of `step` bytes, n in all; reads and writes up to 16 bytes from the start of each pixel.
void thin_out(const uint8_t* x, int64_t step, int64_t n, uint8_t* out) {
  const hn::FixedTag<uint8_t, 16> d;
  const int64_t each = (16 + step) / (2 * step);  // whole pixels among 16 bytes
  int64_t k = 0;
  if (each > 0) {
    alignas(16) uint8_t order[16] = {};
    for (int64_t i = 0; i < each * step; ++i) order[i] = static_cast<uint8_t>(i / step * 2 * step + i % step);
    const auto indices = hn::Load(d, order);
    for (; k < n; k += each)
      hn::StoreU(hn::TableLookupBytes(hn::LoadU(d, x + 2 * k * step), indices), d, out + k * step);
  }
  for (; k < n; ++k) std::memcpy(out + k * step, x + 2 * k * step, static_cast<size_t>(step));
}

}  // namespace

void pyramid_down_bytes(const uint8_t* x, int64_t n, int64_t height, int64_t width, int64_t step,
                        Border border, uint8_t* out) {
  const int64_t new_height = (height + 1) / 2, pixels = (width / step + 1) / 2, reach = 2 * step;
  const int64_t lead = whole_lines<Word>(reach), sums_length = whole_lines<Word>(lead + width + reach),
                bytes_length = whole_lines<uint8_t>(width + 32 + step);
  const auto all_sums = new_lines<Word>(sums_length * omp_get_max_threads());
  const auto all_bytes = new_lines<uint8_t>(2 * bytes_length * omp_get_max_threads());
  const std::vector<uint8_t> zeros(border == Border::kConstant ? static_cast<size_t>(width) : 0);
#pragma omp parallel for
  for (int64_t i = 0; i < n * new_height; ++i) {
    const int64_t image = i / new_height, y = i % new_height;
    Word* const sums = all_sums.get() + sums_length * omp_get_thread_num() + lead;
    uint8_t *const blurred = all_bytes.get() + 2 * bytes_length * omp_get_thread_num(), *const thinned =
                                                                                            blurred +
                                                                                            bytes_length;
    const uint8_t* rows[5];
    for (int64_t k = 0; k < 5; ++k) {
      const int64_t row = inside(2 * y + k - 2, height, border);
      rows[k] = row < 0 ? zeros.data() : x + (image * height + row) * width;
    }
    weigh_down(rows, width, sums);
    extend(sums, Tile{0, 0, 1, 0, width}, width, reach, reach, border, Word{0}, step);
    weigh_along(sums, step, width, blurred);
    thin_out(blurred, step, pixels, thinned);
    std::copy_n(thinned, pixels * step, out + i * pixels * step);
  }
}

namespace {

// sums[x] = upper[x] + 6 middle[x] + lower[x]
void weigh_down_even(const uint8_t* upper, const uint8_t* middle, const uint8_t* lower, int64_t n,
                     Word* sums) {
  for_lanes<Word>(n, [=](auto d, auto, int64_t x) {
    const auto m = words(d, middle + x), ends = hn::Add(words(d, upper + x), words(d, lower + x));
    hn::StoreU(hn::Add(ends, hn::Add(hn::ShiftLeft<2>(m), hn::Add(m, m))), d, sums + x);
  });
}

// sums[x] = 4 (middle[x] + lower[x])
void weigh_down_odd(const uint8_t* middle, const uint8_t* lower, int64_t n, Word* sums) {
  for_lanes<Word>(n, [=](auto d, auto, int64_t x) {
    hn::StoreU(hn::ShiftLeft<2>(hn::Add(words(d, middle + x), words(d, lower + x))), d, sums + x);
  });
}

// Makes two pixels of each along the row, by 1, 6, 1 and by 4, 4, over 64, rounded half up.
void weigh_along_both(const Word* sums, int64_t step, int64_t n, uint8_t* even, uint8_t* odd) {
  for_lanes<Word>(n, [=](auto d, auto, int64_t x) {
    const auto half = hn::Set(d, Word{32});
    const auto a = hn::LoadU(d, sums + x - step), b = hn::LoadU(d, sums + x),
               c = hn::LoadU(d, sums + x + step);
    const auto first = hn::Add(hn::Add(a, c), hn::Add(hn::ShiftLeft<2>(b), hn::Add(b, b)));
    store_bytes(d, hn::ShiftRight<6>(hn::Add(first, half)), even + x);
    store_bytes(d, hn::ShiftRight<6>(hn::Add(hn::ShiftLeft<2>(hn::Add(b, c)), half)), odd + x);
  });
}

// Interleaves the pixels of two rows. Reads up to eight bytes from the start of each pixel.
void take_turns(const uint8_t* even, const uint8_t* odd, int64_t step, int64_t pixels, uint8_t* out) {
  const hn::FixedTag<uint8_t, 16> d;
  const hn::Half<decltype(d)> half;
  const int64_t each = 8 / step;  // pairs of pixels in 16 bytes
  int64_t k = 0;
  if (each > 0) {
    alignas(16) uint8_t order[16] = {};
    for (int64_t i = 0; i < 2 * each * step; ++i)
      order[i] = static_cast<uint8_t>(i / step % 2 * 8 + i / (2 * step) * step + i % step);
    const auto indices = hn::Load(d, order);
    for (; 2 * k * step + 16 <= 2 * pixels * step; k += each) {
      const auto both = hn::Combine(d, hn::LoadU(half, odd + k * step), hn::LoadU(half, even + k * step));
      hn::StoreU(hn::TableLookupBytes(both, indices), d, out + 2 * k * step);
    }
  }
  for (; k < pixels; ++k) {
    std::memcpy(out + 2 * k * step, even + k * step, static_cast<size_t>(step));
    std::memcpy(out + (2 * k + 1) * step, odd + k * step, static_cast<size_t>(step));
  }
}

}  // namespace

void pyramid_up_bytes(const uint8_t* x, int64_t n, int64_t height, int64_t width, int64_t step,
                      uint8_t* out) {
  const int64_t lead = whole_lines<Word>(step), sums_length = whole_lines<Word>(lead + width + step),
                bytes_length = whole_lines<uint8_t>(width + 8);
  const auto all_sums = new_lines<Word>(sums_length * omp_get_max_threads());
  const auto all_bytes = new_lines<uint8_t>(2 * bytes_length * omp_get_max_threads());
#pragma omp parallel for
  for (int64_t i = 0; i < 2 * n * height; ++i) {
    const int64_t image = i / (2 * height), y = i / 2 % height;
    Word* const sums = all_sums.get() + sums_length * omp_get_thread_num() + lead;
    uint8_t *const even = all_bytes.get() + 2 * bytes_length * omp_get_thread_num(), *const odd =
                                                                                         even + bytes_length;
    // Reflected together with the zeros: the second pixel comes before the first, and the last one after
    // itself.
    const auto row = [&](int64_t r) {
      return x + (image * height + std::min(std::abs(r), height - 1)) * width;
    };
    if (i % 2 == 0)
      weigh_down_even(row(y - 1), row(y), row(y + 1), width, sums);
    else
      weigh_down_odd(row(y), row(y + 1), width, sums);
    std::copy_n(sums + (width > step ? step : 0), step, sums - step);
    std::copy_n(sums + width - step, step, sums + width);
    weigh_along_both(sums, step, width, even, odd);
    take_turns(even, odd, step, width / step, out + i * 2 * width);
  }
}

}  // namespace chiasm::kernels
