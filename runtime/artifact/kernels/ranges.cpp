// Pixels of 8 and 16 bits in ranges and above thresholds, and masked pixels.
#include <limits>

#include "declared/ranges.h"
#include "interleaving.h"

namespace chiasm::kernels {
namespace {

template <class Pixel>
constexpr int32_t kLeast = std::numeric_limits<Pixel>::min();
template <class Pixel>
constexpr int32_t kLargest = std::numeric_limits<Pixel>::max();

template <class D>
hn::Vec<D> whole(D d, int32_t value) {
  return hn::Set(d, static_cast<hn::TFromD<D>>(value));
}

// Whether pixels are from `low` to `high`.
template <class D>
hn::Mask<D> between(D d, hn::Vec<D> x, int32_t low, int32_t high) {
  return hn::And(hn::Eq(hn::Max(x, whole(d, low)), x), hn::Eq(hn::Min(x, whole(d, high)), x));
}

// Stores 255 where the mask is set, else 0.
template <class D>
void store_mask(D d, hn::Mask<D> mask, uint8_t* out) {
  if constexpr (sizeof(hn::TFromD<D>) == 1) {
    hn::StoreU(hn::VecFromMask(d, mask), d, out);
  } else {
    const hn::Rebind<uint8_t, D> bytes;
    const hn::RebindToSigned<D> integers;
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(integers, hn::IfThenElseZero(mask, whole(d, 255)))), bytes,
               out);
  }
}

// Bytes of a mask, each widened to a pixel: all bits of it, or none.
template <class D>
hn::Vec<D> load_mask(D d, const uint8_t* mask) {
  if constexpr (sizeof(hn::TFromD<D>) == 1) {
    return hn::LoadU(d, mask);
  } else {
    const hn::Rebind<int8_t, D> bytes;
    const hn::RebindToSigned<D> integers;
    const auto set = hn::LoadU(bytes, reinterpret_cast<const int8_t*>(mask));
    return hn::BitCast(d, hn::PromoteTo(integers, set));
  }
}

// Calls body(d, channels, k) for vectors of interleaved pixels, with each of their channels.
template <int kChannels, class Pixel, class Body>
void for_channels(const Pixel* x, int64_t n, const Body& body) {
  for_lanes<Pixel>(n, [=](auto d, auto, int64_t k) {
    hn::Vec<decltype(d)> channels[kChannels];
    if constexpr (hn::MaxLanes(d) == 1) {
      for (int c = 0; c < kChannels; ++c) channels[c] = hn::Set(d, x[kChannels * k + c]);
    } else {
      load_pixels<kChannels>(d, x + kChannels * k, channels);
    }
    body(d, channels, k);
  });
}

template <int kChannels, class Pixel>
void mask_run(const Pixel* x, const int32_t* low, const int32_t* high, int64_t n, uint8_t* out) {
  for_channels<kChannels>(x, n, [=](auto d, const auto* channels, int64_t k) {
    auto inside = between(d, channels[0], low[0], high[0]);
    for (int c = 1; c < kChannels; ++c) inside = hn::And(inside, between(d, channels[c], low[c], high[c]));
    store_mask(d, inside, out + k);
  });
}

template <int kChannels, class Pixel>
void masked_run(const Pixel* x, const uint8_t* mask, int64_t n, Pixel* out) {
  for_channels<kChannels>(x, n, [=](auto d, auto* channels, int64_t k) {
    const auto wanted = load_mask(d, mask + k);
    for (int c = 0; c < kChannels; ++c) {
      channels[c] = hn::And(channels[c], wanted);
      if constexpr (hn::MaxLanes(d) == 1) out[kChannels * k + c] = hn::GetLane(channels[c]);
    }
    if constexpr (hn::MaxLanes(d) > 1) store_pixels<kChannels>(d, channels, out + kChannels * k);
  });
}

}  // namespace

template <class V>
void in_range(const V* x, int64_t n, int64_t values, const int32_t* low, int64_t sets, int64_t channels,
              const int32_t* high, bool interleaved, uint8_t* out) {
  const int64_t pixels = values / channels;
  for_pixels(n, pixels, [=](int64_t image, int64_t first, int64_t count) {
    const int32_t* const from = low + image / (n / sets) * channels;
    const int32_t* const to = high + image / (n / sets) * channels;
    uint8_t* const mask = out + image * pixels + first;
    for (int64_t c = 0; c < channels; ++c)
      if (from[c] > kLargest<V> || to[c] < kLeast<V> || from[c] > to[c])
        return static_cast<void>(std::fill_n(mask, count, 0));
    // Limits outside of the pixels' range have no effect.
    const auto least = [=](int64_t c) { return std::max(from[c], kLeast<V>); };
    const auto most = [=](int64_t c) { return std::min(to[c], kLargest<V>); };
    const V* const run = x + image * values + (interleaved ? channels * first : first);
    if (interleaved && (channels == 3 || channels == 4)) {
      const int32_t lows[] = {least(0), least(1), least(2), least(channels - 1)},
                    highs[] = {most(0), most(1), most(2), most(channels - 1)};
      return (channels == 3 ? mask_run<3, V> : mask_run<4, V>)(run, lows, highs, count, mask);
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
      const V* const plane = run + c * pixels;
      for_lanes<V>(count, [=](auto d, auto, int64_t k) {
        auto inside = between(d, hn::LoadU(d, plane + k), least(c), most(c));
        if (c > 0) inside = hn::And(inside, hn::MaskFromVec(load_mask(d, mask + k)));
        store_mask(d, inside, mask + k);
      });
    }
  });
}

template <class V>
void masked_pixels(const V* x, int64_t n, int64_t values, const uint8_t* mask, int64_t pixels,
                   bool interleaved, V* out) {
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
          out[i] = static_cast<V>(x[i] & static_cast<int8_t>(wanted[k]));
        }
      return;
    }
    for (int64_t c = 0; c < channels; ++c)
      for_lanes<V>(count, [=](auto d, auto, int64_t k) {
        const int64_t i = at + c * pixels + k;
        hn::StoreU(hn::And(hn::LoadU(d, x + i), load_mask(d, wanted + k)), d, out + i);
      });
  });
}

template <class S>
void split_at(const S* x, int64_t n, int64_t values, const int32_t* limits, int64_t sets, bool keep_above,
              bool keep_below, S* out) {
  for_pixels(n, values, [=](int64_t image, int64_t first, int64_t count) {
    const int32_t* const set = limits + 3 * (image / (n / sets));
    const int32_t limit = set[0];
    const int64_t at = image * values + first;
    const auto level = [](int32_t value) { return std::clamp(value, kLeast<S>, kLargest<S>); };
    const int32_t high = level(set[1]), low = level(set[2]);
    for_lanes<S>(count, [=](auto d, auto, int64_t k) {
      const auto pixels = hn::LoadU(d, x + at + k);
      const auto above = keep_above ? pixels : whole(d, high), below = keep_below ? pixels : whole(d, low);
      if (limit < kLeast<S>) return hn::StoreU(above, d, out + at + k);
      const auto is_above = hn::Gt(pixels, whole(d, std::min(limit, kLargest<S>)));
      hn::StoreU(hn::IfThenElse(is_above, above, below), d, out + at + k);
    });
  });
}

CHIASM_INSTANTIATE(in_range)
CHIASM_INSTANTIATE(masked_pixels)
CHIASM_INSTANTIATE(split_at)

}  // namespace chiasm::kernels
