// Arithmetic on integer pixels, value by value.
#include "declared/arithmetic.h"
#include "interleaving.h"

namespace chiasm::kernels {

template <class P>
void subtract_pixels(const P* x, int64_t n, int64_t values, const P* y, P* out) {
  for_pixels(1, n * values, [=](int64_t, int64_t first, int64_t count) {
    for_lanes<P>(count, [=](auto d, auto, int64_t k) {
      const auto a = hn::LoadU(d, x + first + k), b = hn::LoadU(d, y + first + k);
      if constexpr (std::is_floating_point_v<P>)
        hn::StoreU(hn::Sub(a, b), d, out + first + k);
      else
        hn::StoreU(hn::SaturatedSub(a, b), d, out + first + k);
    });
  });
}

void add_weighted(const uint8_t* x, int64_t n, int64_t values, const uint8_t* y, const float* weights,
                  int64_t sets, uint8_t* out) {
  for_pixels(n, values, [=](int64_t image, int64_t first, int64_t count) {
    const float* const w = weights + 3 * (image / (n / sets));
    const int64_t at = image * values + first;
    map_levels<2, 1>({x + at, y + at}, count, {out + at}, [=](auto d, const auto* numbers, auto* levels) {
      const auto sum =
          hn::Add(hn::Add(hn::Mul(numbers[0], hn::Set(d, w[0])), hn::Mul(numbers[1], hn::Set(d, w[1]))),
                  hn::Set(d, w[2]));
      // NaN becomes 0
      levels[0] = nearest_level(d, smaller(larger(sum, hn::Zero(d)), hn::Set(d, 255.0f)));
    });
  });
}

void scaled_bytes(const uint8_t* x, int64_t n, int64_t values, const int32_t* order, int64_t planes,
                  const float* by, int64_t channels, bool interleaved, float* out) {
  const int64_t pixels = values / channels, most = kPart / channels;
  const int64_t parts = (pixels + most - 1) / most;
#pragma omp parallel for
  for (int64_t i = 0; i < n * parts; ++i) {
    const int64_t image = i / parts, first = i % parts * most, count = std::min(most, pixels - first);
    uint8_t apart[kPart];
    const uint8_t* from = x + image * values + first;
    int64_t plane = pixels;
    if (interleaved) {
      split_channels(x + image * values + first * channels, count, channels, count, apart);
      from = apart;
      plane = count;
    }
    for (int64_t o = 0; o < planes; ++o) {
      float* const to = out + (image * planes + o) * pixels + first;
      const float factor = by[2 * o], added = by[2 * o + 1];
      if (order[o] < 0 || order[o] >= channels) {
        std::fill_n(to, count, 0.0f * factor + added);
        continue;
      }
      const uint8_t* const channel = from + order[o] * plane;
      for_lanes<float, 4>(count, [=](auto d, auto vectors, int64_t k) {
        const auto lanes = static_cast<int64_t>(hn::Lanes(d));
        for (int v = 0; v < vectors; ++v) {
          const int64_t at = k + v * lanes;
          const auto product = hn::Mul(number(d, channel + at), hn::Set(d, factor));
          hn::StoreU(hn::Add(product, hn::Set(d, added)), d, to + at);
        }
      });
    }
  }
}

CHIASM_INSTANTIATE(subtract_pixels)

}  // namespace chiasm::kernels
