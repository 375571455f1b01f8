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

namespace {

// 255 for bytes from `low` to `high`, else 0.
template <class D>
hn::Vec<D> between(D d, hn::Vec<D> x, int32_t low, int32_t high) {
  const auto least = hn::Set(d, static_cast<uint8_t>(low)), most = hn::Set(d, static_cast<uint8_t>(high));
  return hn::VecFromMask(d, hn::And(hn::Eq(hn::Max(x, least), x), hn::Eq(hn::Min(x, most), x)));
}

template <int kChannels>
void mask_run(const uint8_t* x, const int32_t* low, const int32_t* high, int64_t n, uint8_t* out) {
  for_lanes<uint8_t>(n, [=](auto d, auto, int64_t k) {
    hn::Vec<decltype(d)> channels[kChannels];
    if constexpr (hn::MaxLanes(d) == 1) {
      for (int c = 0; c < kChannels; ++c) channels[c] = hn::Set(d, x[kChannels * k + c]);
    } else {
      load_pixels<kChannels>(d, x + kChannels * k, channels);
    }
    auto inside = between(d, channels[0], low[0], high[0]);
    for (int c = 1; c < kChannels; ++c) inside = hn::And(inside, between(d, channels[c], low[c], high[c]));
    hn::StoreU(inside, d, out + k);
  });
}

}  // namespace

void in_range(const uint8_t* x, int64_t n, int64_t values, const int32_t* low, int64_t sets, int64_t channels,
              const int32_t* high, bool interleaved, uint8_t* out) {
  const int64_t pixels = values / channels;
  for_pixels(n, pixels, [=](int64_t image, int64_t first, int64_t count) {
    const int32_t* const from = low + image / (n / sets) * channels;
    const int32_t* const to = high + image / (n / sets) * channels;
    uint8_t* const mask = out + image * pixels + first;
    for (int64_t c = 0; c < channels; ++c)
      if (from[c] > 255 || to[c] < 0 || from[c] > to[c])
        return static_cast<void>(std::fill_n(mask, count, 0));
    // Limits outside of the bytes' range have no effect.
    const auto least = [=](int64_t c) { return std::max(from[c], 0); };
    const auto most = [=](int64_t c) { return std::min(to[c], 255); };
    const uint8_t* const run = x + image * values + (interleaved ? channels * first : first);
    if (interleaved && (channels == 3 || channels == 4)) {
      const int32_t lows[] = {least(0), least(1), least(2), least(channels - 1)},
                    highs[] = {most(0), most(1), most(2), most(channels - 1)};
      return (channels == 3 ? mask_run<3> : mask_run<4>)(run, lows, highs, count, mask);
    }
    if (interleaved && channels > 1) {
      for (int64_t k = 0; k < count; ++k) {
        mask[k] = 255;
        for (int64_t c = 0; c < channels; ++c) {
          const int32_t value = run[k * channels + c];
          if (value < from[c] || value > to[c]) mask[k] = 0;
        }
      }
      return;
    }
    for (int64_t c = 0; c < channels; ++c) {
      const uint8_t* const plane = run + c * pixels;
      for_lanes<uint8_t>(count, [=](auto d, auto, int64_t k) {
        const auto inside = between(d, hn::LoadU(d, plane + k), least(c), most(c));
        hn::StoreU(c == 0 ? inside : hn::And(inside, hn::LoadU(d, mask + k)), d, mask + k);
      });
    }
  });
}

namespace {

template <int kChannels>
void masked_run(const uint8_t* x, const uint8_t* mask, int64_t n, uint8_t* out) {
  for_lanes<uint8_t>(n, [=](auto d, auto, int64_t k) {
    if constexpr (hn::MaxLanes(d) == 1) {
      for (int c = 0; c < kChannels; ++c) out[kChannels * k + c] = x[kChannels * k + c] & mask[k];
    } else {
      hn::Vec<decltype(d)> channels[kChannels];
      load_pixels<kChannels>(d, x + kChannels * k, channels);
      for (auto& channel : channels) channel = hn::And(channel, hn::LoadU(d, mask + k));
      store_pixels<kChannels>(d, channels, out + kChannels * k);
    }
  });
}

}  // namespace

void masked_pixels(const uint8_t* x, int64_t n, int64_t values, const uint8_t* mask, int64_t pixels,
                   bool interleaved, uint8_t* out) {
  const int64_t channels = values / pixels;
  for_pixels(n, pixels, [=](int64_t image, int64_t first, int64_t count) {
    const uint8_t* const wanted = mask + image * pixels + first;
    const int64_t at = image * values + (interleaved ? channels * first : first);
    if (interleaved && channels == 3) return masked_run<3>(x + at, wanted, count, out + at);
    if (interleaved && channels == 4) return masked_run<4>(x + at, wanted, count, out + at);
    if (interleaved && channels > 1) {
      for (int64_t k = 0; k < count; ++k)
        for (int64_t c = 0; c < channels; ++c) {
          const int64_t i = at + k * channels + c;
          out[i] = x[i] & wanted[k];
        }
      return;
    }
    for (int64_t c = 0; c < channels; ++c)
      for_lanes<uint8_t>(count, [=](auto d, auto, int64_t k) {
        const int64_t i = at + c * pixels + k;
        hn::StoreU(hn::And(hn::LoadU(d, x + i), hn::LoadU(d, wanted + k)), d, out + i);
      });
  });
}

CHIASM_INSTANTIATE(subtract_pixels)

}  // namespace chiasm::kernels
