// First derivatives of bytes by windows of 3 x 3, in integers; the border is replicated.
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

// scale sqrt(a^2 + b^2), rounded half to even: the sums of squares are integers below 2^24, exact in float32.
template <class D>
HWY_INLINE hn::Vec<Integers<D>> lengths(D, hn::Vec<D> a, hn::Vec<D> b, float scale) {
  const hn::Rebind<float, D> numbers;
  const auto squared = [=](auto v) {
    const auto number = hn::ConvertTo(numbers, hn::PromoteTo(Integers<D>(), v));
    return hn::Mul(number, number);
  };
  const auto length = hn::Sqrt(hn::Add(squared(a), squared(b)));
  return hn::NearestInt(hn::Mul(length, hn::Set(numbers, scale)));
}

template <class D>
HWY_INLINE hn::Vec<hn::Rebind<uint8_t, D>> length_bytes(D d, hn::Vec<D> a, hn::Vec<D> b, float scale) {
  const hn::Rebind<uint8_t, D> bytes;
  if constexpr (hn::MaxLanes(d) == 1) {
    return hn::DemoteTo(bytes, lengths(d, a, b, scale));
  } else {
    const hn::Half<D> half;
    const auto low = lengths(half, hn::LowerHalf(half, a), hn::LowerHalf(half, b), scale);
    const auto high = lengths(half, hn::UpperHalf(half, a), hn::UpperHalf(half, b), scale);
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

}  // namespace

void derivatives_of_bytes(const uint8_t* x, int64_t n, int64_t height, int64_t width, int64_t side,
                          int64_t centre, int16_t* out) {
  if (side == 1 && centre == 2) return derivatives(x, n, height, width, Sobel(), out);
  derivatives(x, n, height, width, Smoothing{static_cast<int16_t>(side), static_cast<int16_t>(centre)}, out);
}

void sobel_bytes(const uint8_t* x, int64_t n, int64_t height, int64_t length, int64_t step, double scale,
                 uint8_t* out) {
#pragma omp parallel for
  for (int64_t row = 0; row < n * height; ++row) {
    uint8_t* const to = out + row * length;
    for_sums({x, row, height, length, step}, Sobel(), [=](auto d, int64_t k, auto across, auto down) {
      hn::StoreU(length_bytes(d, across, down, static_cast<float>(scale)), hn::Rebind<uint8_t, decltype(d)>(),
                 to + k);
    });
  }
}

}  // namespace chiasm::kernels
