// First derivatives of bytes by windows of 3 x 3, in integers; the border is replicated.
#include <bit>

#include "declared/derivatives_bytes.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// A row of an image and its neighbours, in which pixels are `step` values apart.
struct Neighbours {
  const uint8_t *above, *here, *below;
  int64_t values, step;

  Neighbours(const uint8_t* x, int64_t row, int64_t height, int64_t values_in, int64_t step_in)
      : values(values_in), step(step_in) {
    const int64_t plane = row / height, y = row % height;
    const auto at = [=](int64_t i) {
      return x + (plane * height + std::clamp<int64_t>(i, 0, height - 1)) * values_in;
    };
    above = at(y - 1);
    here = at(y);
    below = at(y + 1);
  }
};

// The weights of Sobel's windows, across the derivative.
struct Sobel {
  template <class V>
  HWY_INLINE V operator()(V first, V middle, V last) const {
    return hn::Add(hn::Add(first, hn::Add(middle, middle)), last);
  }
};

// Other weights: Scharr's, Prewitt's.
struct Smoothing {
  int16_t side, centre;

  template <class V>
  HWY_INLINE V operator()(V first, V middle, V last) const {
    const hn::DFromV<V> d;
    return hn::Add(hn::Mul(hn::Add(first, last), hn::Set(d, side)), hn::Mul(middle, hn::Set(d, centre)));
  }
};

// The sums along the row and down the column of the values l, k and r.
template <class D, class Smooth>
HWY_INLINE void sums(D d, const Neighbours& rows, const Smooth& smooth, int64_t l, int64_t k, int64_t r,
                     hn::Vec<D>& across, hn::Vec<D>& down) {
  const hn::Rebind<uint8_t, D> bytes;
  const auto read = [=](const uint8_t* p, int64_t i) { return hn::PromoteTo(d, hn::LoadU(bytes, p + i)); };
  const auto slope = [=](const uint8_t* p) { return hn::Sub(read(p, r), read(p, l)); };
  const auto drop = [=](int64_t i) { return hn::Sub(read(rows.below, i), read(rows.above, i)); };
  across = smooth(slope(rows.above), slope(rows.here), slope(rows.below));
  down = smooth(drop(l), drop(k), drop(r));
}

// Calls use(tag, first, across, down) with the sums of all values of a row; it may be called twice for some.
template <class Smooth, class Use>
HWY_INLINE void for_sums(const Neighbours rows, const Smooth smooth, const Use& use) {
  const auto one = [=](int64_t k) {
    const Lane<int16_t> d;
    hn::Vec<Lane<int16_t>> across, down;
    sums(d, rows, smooth, k < rows.step ? k : k - rows.step, k,
         k + rows.step < rows.values ? k + rows.step : k, across, down);
    use(d, k, across, down);
  };
  for (int64_t k = 0; k < rows.step; ++k) one(k);
  for_lanes<int16_t, 1, true>(rows.values - 2 * rows.step, [=](auto d, auto, int64_t k) {
    hn::Vec<decltype(d)> across, down;
    sums(d, rows, smooth, k, k + rows.step, k + 2 * rows.step, across, down);
    use(d, k + rows.step, across, down);
  });
  for (int64_t k = std::max(rows.step, rows.values - rows.step); k < rows.values; ++k) one(k);
}

// sqrt(a^2 + b^2) / divisor, rounded half to even. Sums of squares of Sobel's sums are integers below 2^24,
// exact in float32, so that its roots are whole or further from a half than their rounding errors.
struct SobelLengths {
  float scale;

  template <class D>
  HWY_INLINE hn::Vec<D> operator()(D, hn::Vec<D> squares) const {
    const hn::Rebind<float, D> numbers;
    const auto length = hn::Sqrt(hn::ConvertTo(numbers, squares));
    return hn::NearestInt(hn::Mul(length, hn::Set(numbers, scale)));
  }
};

// For larger sums the root is an estimate: the result r is right if (2 r - 1) divisor <= 2 sqrt(squares) <=
// (2 r + 1) divisor, whose squares are integers below 2^31; where two are equal, r is even.
struct Lengths {
  int32_t divisor;

  template <class D>
  HWY_INLINE hn::Vec<D> operator()(D d, hn::Vec<D> squares) const {
    const hn::Rebind<float, D> numbers;
    const auto one = hn::Set(d, 1), zero = hn::Zero(d);
    const auto length = hn::Sqrt(hn::ConvertTo(numbers, squares));
    const auto quotient = hn::Mul(length, hn::Set(numbers, 1.0f / static_cast<float>(divisor)));
    const auto guess = hn::NearestInt(smaller(quotient, hn::Set(numbers, 255.0f)));
    const auto twice = hn::Add(guess, guess), four = hn::ShiftLeft<2>(squares);
    const auto square_of = [=, this](auto odd) {
      const auto scaled = hn::Mul(odd, hn::Set(d, divisor));
      return hn::Mul(scaled, scaled);
    };
    const auto above = square_of(hn::Add(twice, one)), below = square_of(hn::Sub(twice, one));
    const auto is_odd = hn::Ne(hn::And(guess, one), zero);
    const auto up = hn::Or(hn::Gt(four, above), hn::And(hn::Eq(four, above), is_odd));
    const auto down =
        hn::And(hn::Gt(guess, zero), hn::Or(hn::Lt(four, below), hn::And(hn::Eq(four, below), is_odd)));
    return hn::Sub(hn::Add(guess, hn::IfThenElseZero(up, one)), hn::IfThenElseZero(down, one));
  }
};

template <class D, class Lengths>
HWY_INLINE hn::Vec<hn::Rebind<uint8_t, D>> length_bytes(D d, hn::Vec<D> a, hn::Vec<D> b, Lengths lengths) {
  const hn::Rebind<uint8_t, D> bytes;
  const auto of = [=](auto part, auto x, auto y) {
    const auto squared = [=](auto v) {
      const auto wide = hn::PromoteTo(Integers<decltype(part)>(), v);
      return hn::Mul(wide, wide);
    };
    return lengths(Integers<decltype(part)>(), hn::Add(squared(x), squared(y)));
  };
  if constexpr (hn::MaxLanes(d) == 1) {
    return hn::DemoteTo(bytes, of(d, a, b));
  } else {
    const hn::Half<D> half;
    const auto low = of(half, hn::LowerHalf(half, a), hn::LowerHalf(half, b));
    const auto high = of(half, hn::UpperHalf(half, a), hn::UpperHalf(half, b));
    return hn::DemoteTo(bytes, hn::Combine(d, hn::DemoteTo(half, high), hn::DemoteTo(half, low)));
  }
}

template <class Smooth>
void derivatives(const uint8_t* x, int64_t n, int64_t height, int64_t width, Smooth smooth, int16_t* out) {
#pragma omp parallel for
  for (int64_t row = 0; row < n * height; ++row) {
    int16_t* const along = out + (row / height * 2 * height + row % height) * width;
    int16_t* const downwards = along + height * width;
    for_sums({x, row, height, width, 1}, smooth, [=](auto d, int64_t k, auto across, auto down) {
      hn::StoreU(across, d, along + k);
      hn::StoreU(down, d, downwards + k);
    });
  }
}

template <class Smooth, class Lengths>
void magnitudes(const uint8_t* x, int64_t n, int64_t height, int64_t length, int64_t step, Smooth smooth,
                Lengths lengths, uint8_t* out) {
#pragma omp parallel for
  for (int64_t row = 0; row < n * height; ++row) {
    uint8_t* const to = out + row * length;
    for_sums({x, row, height, length, step}, smooth, [=](auto d, int64_t k, auto across, auto down) {
      hn::StoreU(length_bytes(d, across, down, lengths), hn::Rebind<uint8_t, decltype(d)>(), to + k);
    });
  }
}

}  // namespace

void derivatives_of_bytes(const uint8_t* x, int64_t n, int64_t height, int64_t width, int64_t side,
                          int64_t centre, int16_t* out) {
  if (side == 1 && centre == 2) return derivatives(x, n, height, width, Sobel(), out);
  derivatives(x, n, height, width, Smoothing{static_cast<int16_t>(side), static_cast<int16_t>(centre)}, out);
}

void magnitude_of_bytes(const uint8_t* x, int64_t n, int64_t height, int64_t length, int64_t step,
                        int64_t side, int64_t centre, int64_t divisor, uint8_t* out) {
  if (side == 1 && centre == 2 && std::has_single_bit(static_cast<uint64_t>(divisor)))
    return magnitudes(x, n, height, length, step, Sobel(), SobelLengths{1.0f / static_cast<float>(divisor)},
                      out);
  magnitudes(x, n, height, length, step, Smoothing{static_cast<int16_t>(side), static_cast<int16_t>(centre)},
             Lengths{static_cast<int32_t>(divisor)}, out);
}

}  // namespace chiasm::kernels
