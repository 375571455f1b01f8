// Colours of bytes: mixed channels, luma and chroma, hues, and curves before and after mixing.
#include <array>

#include "declared/colour_bytes.h"
#include "interleaving.h"

namespace chiasm::kernels {
namespace {

// One channel of a mix: the weights of the three channels, and the offset that is added before the shift.
struct Mix {
  int32_t weights[3], offset;
};

// Stores rounded numbers as bytes; numbers outside of 0 to 255 are saturated.
template <class D>
HWY_INLINE void store_levels(D, hn::Vec<Integers<D>> levels, uint8_t* out) {
  const hn::Rebind<uint8_t, D> bytes;
  hn::StoreU(hn::DemoteTo(bytes, levels), bytes, out);
}

// kRows sums of three planes of n bytes, `plane` bytes apart. Products of weights and bytes are integers that
// float32 represents exactly; a float32 product is one instruction, an int32 product two.
template <int kRows>
void mix_planes(const uint8_t* x, int64_t plane, const Mix* mixes, float scale, int64_t n, uint8_t* out,
                int64_t out_plane) {
  std::array<std::array<float, 4>, kRows> rows;
  for (int r = 0; r < kRows; ++r) {
    for (size_t c = 0; c < 3; ++c) rows[r][c] = static_cast<float>(mixes[r].weights[c]);
    rows[r][3] = static_cast<float>(mixes[r].offset);
  }
  for_lanes<float, 2>(n, [=](auto d, auto vectors, int64_t k) {
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    for (int v = 0; v < vectors; ++v) {
      const uint8_t* const p = x + k + v * lanes;
      const auto a = number(d, p), b = number(d, p + plane), c = number(d, p + 2 * plane);
      for (int r = 0; r < kRows; ++r) {
        const auto weight = [&](size_t i) { return hn::Set(d, rows[r][i]); };
        const auto sum = hn::Add(hn::Add(hn::Mul(a, weight(0)), hn::Mul(b, weight(1))),
                                 hn::Add(hn::Mul(c, weight(2)), weight(3)));
        // Limited here, because Highway's demotion to bytes by AVX2 does not saturate numbers from 2^15 to
        // 2^15 + 254. Negative numbers become 0, so truncation rounds down.
        const auto level = hn::Min(hn::Mul(sum, hn::Set(d, scale)), hn::Set(d, 255.0f));
        store_levels(d, hn::ConvertTo(Integers<decltype(d)>(), level), out + r * out_plane + k + v * lanes);
      }
    }
  });
}

// Whether no weight is negative and the sums of the weights' high and low bytes fit into 16 bits. Then both
// are weighted separately, with twice as many values in a vector.
bool fits_words(const Mix& mix, int64_t shift) {
  int32_t high = 0, low = 0;
  for (const int32_t weight : mix.weights) {
    if (weight < 0) return false;
    high += weight >> 8;
    low += weight & 255;
  }
  return mix.offset >= 0 && mix.offset % 256 == 0 && shift >= 9 && low <= 257 &&
         int64_t{high} * 255 + mix.offset / 256 + 255 <= UINT16_MAX;
}

void mix_words(const uint8_t* x, int64_t plane, const Mix& mix, int64_t shift, int64_t n, uint8_t* out) {
  const std::array<int32_t, 3> weights{mix.weights[0], mix.weights[1], mix.weights[2]};
  const int32_t offset = mix.offset / 256;
  const int more = static_cast<int>(shift) - 8;
  for_lanes<uint16_t, 2>(n, [=](auto d, auto vectors, int64_t k) {
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    const hn::RebindToSigned<decltype(d)> integers;
    const auto word = [=](int32_t value) { return hn::Set(d, static_cast<uint16_t>(value)); };
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    for (int v = 0; v < vectors; ++v) {
      auto high = word(offset), low = hn::Zero(d);
      for (size_t c = 0; c < 3; ++c) {
        const auto value =
            hn::PromoteTo(d, hn::LoadU(bytes, x + static_cast<int64_t>(c) * plane + k + v * lanes));
        high = hn::Add(high, hn::Mul(value, word(weights[c] >> 8)));
        low = hn::Add(low, hn::Mul(value, word(weights[c] & 255)));
      }
      const auto level = hn::ShiftRightSame(hn::Add(high, hn::ShiftRight<8>(low)), more);
      hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(integers, level)), bytes, out + k + v * lanes);
    }
  });
}

// Converts bytes to 16-bit numbers, even and odd pixels separately, and back.
template <class D>
struct Halves {
  using Words = hn::Repartition<int16_t, D>;
  hn::Vec<Words> even, odd;

  static HWY_INLINE Halves of(D, hn::Vec<D> bytes) {
    const hn::Repartition<uint16_t, D> unsigneds;
    const auto both = hn::BitCast(unsigneds, bytes);
    const Words words;
    return {hn::BitCast(words, hn::And(both, hn::Set(unsigneds, uint16_t{255}))),
            hn::BitCast(words, hn::ShiftRight<8>(both))};
  }

  HWY_INLINE hn::Vec<D> saturated(D d) const {
    const Words words;
    const auto level = [=](hn::Vec<Words> x) {
      return hn::Min(hn::Max(x, hn::Zero(words)), hn::Set(words, int16_t{255}));
    };
    return hn::BitCast(d, hn::Or(level(even), hn::ShiftLeft<8>(level(odd))));
  }
};

// Sums of four products for every pixel. The 16-bit numbers are in pairs, for the instruction that adds two
// products to 32 bits.
template <class D>
struct Pairs {
  using Words = hn::Repartition<int16_t, D>;
  using Integers = hn::Repartition<int32_t, D>;
  hn::Vec<Words> first[4], second[4];

  HWY_INLINE Pairs(D, const Halves<D>& a, const Halves<D>& b, const Halves<D>& c, const Halves<D>& again) {
    join(a, b, first);
    join(c, again, second);
  }

  static HWY_INLINE void join(const Halves<D>& a, const Halves<D>& b, hn::Vec<Words>* to) {
    const Words words;
    to[0] = hn::InterleaveLower(words, a.even, b.even);
    to[1] = hn::InterleaveUpper(words, a.even, b.even);
    to[2] = hn::InterleaveLower(words, a.odd, b.odd);
    to[3] = hn::InterleaveUpper(words, a.odd, b.odd);
  }

  // Weights both numbers of each pair, adds an offset, and divides by 2^by.
  HWY_INLINE Halves<D> sums(hn::Vec<Words> by_first, hn::Vec<Words> by_second, hn::Vec<Integers> offset,
                            int by) const {
    const Words words;
    const Integers integers;
    const auto sum = [&](int q) {
      auto even = hn::Zero(integers), odd = even;
      even = hn::ReorderWidenMulAccumulate(integers, first[q], by_first, even, odd);
      even = hn::ReorderWidenMulAccumulate(integers, second[q], by_second, even, odd);
      return hn::ShiftRightSame(hn::Add(hn::RearrangeToOddPlusEven(even, odd), offset), by);
    };
    return {hn::ReorderDemote2To(words, sum(0), sum(1)), hn::ReorderDemote2To(words, sum(2), sum(3))};
  }
};

// 16-bit weights of the three channels, and a second weight for one of them, `again`, for a weight that does
// not fit into 16 bits.
struct WordMix {
  std::array<std::array<int16_t, 4>, 3> weights;
  std::array<int32_t, 3> offsets;
  int64_t again;
};

// Whether the weights fit into 16 bits, except those of one channel, which may have 17.
bool split_weights(const Mix* mixes, int64_t rows, WordMix& words) {
  words.again = 2;
  for (int64_t r = 0; r < rows; ++r)
    for (int64_t c = 0; c < 3; ++c)
      if (mixes[r].weights[c] != std::clamp<int32_t>(mixes[r].weights[c], INT16_MIN, INT16_MAX))
        words.again = c;
  for (int64_t r = 0; r < rows; ++r) {
    auto& split = words.weights[static_cast<size_t>(r)];
    split[3] = 0;
    for (int64_t c = 0; c < 3; ++c) {
      const int32_t weight = mixes[r].weights[c], part = std::clamp<int32_t>(weight, INT16_MIN, INT16_MAX),
                    rest = weight - part;
      split[static_cast<size_t>(c)] = static_cast<int16_t>(part);
      if (rest == 0) continue;
      if (c != words.again || rest != std::clamp<int32_t>(rest, INT16_MIN, INT16_MAX)) return false;
      split[3] = static_cast<int16_t>(rest);
    }
    words.offsets[static_cast<size_t>(r)] = mixes[r].offset;
  }
  return true;
}

// Two weights for all pairs.
template <class D>
HWY_INLINE hn::Vec<D> pair(D words, int16_t first, int16_t second) {
  const hn::Repartition<int32_t, D> integers;
  return hn::BitCast(words, hn::Set(integers, int32_t{static_cast<uint16_t>(first)} | second * 65536));
}

// kRows sums of three planes, in products of 16 bits.
template <int kRows>
void mix_pairs(const uint8_t* x, int64_t plane, const WordMix& mix, int64_t shift, int64_t n, uint8_t* out,
               int64_t out_plane) {
  const int by = static_cast<int>(shift);
  for_lanes<uint8_t>(n, [=](auto d, auto, int64_t k) {
    using D = decltype(d);
    const uint8_t* const p = x + k;
    if constexpr (hn::MaxLanes(d) == 1) {
      for (size_t r = 0; r < kRows; ++r) {
        // Without a sign, because sums that do not fit wrap around, as in vectors.
        const auto part = [](int32_t number) { return static_cast<uint32_t>(number); };
        uint32_t sum = part(mix.offsets[r]) + part(mix.weights[r][3] * p[mix.again * plane]);
        for (size_t c = 0; c < 3; ++c) sum += part(mix.weights[r][c] * p[static_cast<int64_t>(c) * plane]);
        const int32_t level = static_cast<int32_t>(sum) >> by;
        out[static_cast<int64_t>(r) * out_plane + k] = static_cast<uint8_t>(std::clamp(level, 0, 255));
      }
    } else {
      const hn::Repartition<int16_t, D> words;
      const hn::Repartition<int32_t, D> integers;
      const auto halves = [=](int64_t channel) {
        return Halves<D>::of(d, hn::LoadU(d, p + channel * plane));
      };
      const Pairs<D> pairs(d, halves(0), halves(1), halves(2), halves(mix.again));
      for (size_t r = 0; r < kRows; ++r) {
        const auto& w = mix.weights[r];
        const auto sums = pairs.sums(pair(words, w[0], w[1]), pair(words, w[2], w[3]),
                                     hn::Set(integers, mix.offsets[r]), by);
        hn::StoreU(sums.saturated(d), d, out + static_cast<int64_t>(r) * out_plane + k);
      }
    }
  });
}

// A luma, and two chroma: 128 plus the difference of a channel and luma times a factor. Weights and factors
// are in 1/2^14, and results are rounded half up.
struct LumaChroma {
  int16_t weights[3], first, second;
};

void luma_chroma_planes(const uint8_t* x, int64_t plane, const LumaChroma& mix, int64_t n, uint8_t* out,
                        int64_t out_plane) {
  for_lanes<uint8_t>(n, [=](auto d, auto, int64_t k) {
    using D = decltype(d);
    const uint8_t* const p = x + k;
    uint8_t* const to = out + k;
    if constexpr (hn::MaxLanes(d) == 1) {
      const int32_t r = p[0], g = p[plane], b = p[2 * plane];
      const int32_t luma = (mix.weights[0] * r + mix.weights[1] * g + mix.weights[2] * b + 8192) >> 14;
      const auto level = [](int32_t value) { return static_cast<uint8_t>(std::clamp(value, 0, 255)); };
      to[0] = level(luma);
      to[out_plane] = level(128 + ((mix.first * (b - luma) + 8192) >> 14));
      to[2 * out_plane] = level(128 + ((mix.second * (r - luma) + 8192) >> 14));
    } else {
      const hn::Repartition<int16_t, D> words;
      const hn::Repartition<int32_t, D> integers;
      const auto halves = [=](int64_t channel) {
        return Halves<D>::of(d, hn::LoadU(d, p + channel * plane));
      };
      const auto red = halves(0), green = halves(1), blue = halves(2);
      const auto none = hn::Zero(words);
      const auto luma = Pairs<D>(d, red, green, blue, {none, none})
                            .sums(pair(words, mix.weights[0], mix.weights[1]), pair(words, mix.weights[2], 0),
                                  hn::Set(integers, 8192), 14);
      hn::StoreU(luma.saturated(d), d, to);
      const auto store = [=](const Halves<D>& channel, int16_t factor, uint8_t* where) {
        const auto around = [=](auto value, auto level) {
          const auto above = hn::Sub(value, level);
          // (2 above * factor + 2^14) / 2^15
          const auto scaled = hn::MulFixedPoint15(hn::Add(above, above), hn::Set(words, factor));
          return hn::Add(scaled, hn::Set(words, int16_t{128}));
        };
        const Halves<D> made{around(channel.even, luma.even), around(channel.odd, luma.odd)};
        hn::StoreU(made.saturated(d), d, where);
      };
      store(blue, mix.first, to + out_plane);
      store(red, mix.second, to + 2 * out_plane);
    }
  });
}

// Hue in degrees / 2, with saturation and value, or lightness and saturation, 0 to 255: rounded half to even,
// lightness half up. All but the two quotients is computed in bytes. Quotients are of integers below 2^16: a
// quotient that is not a half is further from a half than float32's rounding error.
template <bool kLightness>
void hue_planes(const uint8_t* x, int64_t plane, int64_t n, uint8_t* out, int64_t out_plane) {
  constexpr int64_t kRun = 1024;
  // The hue is `sector` plus or minus (where `before` is 255) 30 times the quotient of `apart` and `chroma`.
  uint8_t apart[kRun], chroma[kRun], sector[kRun], before[kRun], most[kRun];
  uint8_t *const hue = out, *const level = out + (kLightness ? 1 : 2) * out_plane,
                 *const saturation = out + (kLightness ? 2 : 1) * out_plane;
  for (int64_t first = 0; first < n; first += kRun) {
    const int64_t count = std::min(kRun, n - first);
    for_lanes<uint8_t>(count, [&](auto d, auto, int64_t k) {
      const uint8_t* const p = x + first + k;
      const auto r = hn::LoadU(d, p), g = hn::LoadU(d, p + plane), b = hn::LoadU(d, p + 2 * plane);
      const auto value = hn::Max(hn::Max(r, g), b), least = hn::Min(hn::Min(r, g), b);
      const auto is_red = hn::Eq(value, r), is_green = hn::Eq(value, g);
      const auto one = hn::IfThenElse(is_red, g, hn::IfThenElse(is_green, b, r));
      const auto other = hn::IfThenElse(is_red, b, hn::IfThenElse(is_green, r, g));
      const auto is_before = hn::Lt(one, other);
      const auto whole = [=](uint8_t number) { return hn::Set(d, number); };
      const auto red = hn::IfThenElseZero(is_before, whole(180));
      const auto at = hn::IfThenElse(is_red, red, hn::IfThenElse(is_green, whole(60), whole(120)));
      hn::StoreU(hn::Sub(hn::Max(one, other), hn::Min(one, other)), d, apart + k);
      hn::StoreU(hn::Sub(value, least), d, chroma + k);
      hn::StoreU(at, d, sector + k);
      hn::StoreU(hn::VecFromMask(d, is_before), d, before + k);
      const auto light =
          hn::Min(hn::SaturatedAdd(value, least), hn::SaturatedAdd(hn::Not(value), hn::Not(least)));
      hn::StoreU(kLightness ? light : value, d, most + k);
      hn::StoreU(kLightness ? hn::AverageRound(value, least) : value, d, level + first + k);
    });
    map_levels<3, 2>({apart, chroma, most}, count, {hue + first, saturation + first},
                     [](auto d, const auto* numbers, auto* levels) {
                       const auto whole = [=](float number) { return hn::Set(d, number); };
                       const auto ratio = [=](float factor, auto a, auto b) {
                         return nearest_level(d, hn::Div(hn::Mul(whole(factor), a), hn::Max(b, whole(1))));
                       };
                       levels[0] = ratio(30, numbers[0], numbers[1]);
                       levels[1] = ratio(255, numbers[1], numbers[2]);
                     });
    for_lanes<uint8_t>(count, [&](auto d, auto, int64_t k) {
      const auto turn = hn::LoadU(d, hue + first + k), at = hn::LoadU(d, sector + k);
      const auto is_before = hn::MaskFromVec(hn::LoadU(d, before + k));
      const auto turned = hn::IfThenElse(is_before, hn::Sub(at, turn), hn::Add(at, turn));
      hn::StoreU(hn::IfThenZeroElse(hn::Eq(turned, hn::Set(d, uint8_t{180})), turned), d, hue + first + k);
    });
  }
}

// The inverse: red, green, blue, rounded half up. A channel is an integer below 2^21, divided by 30 * 255 or
// 15 * 255. A half is added to the integer, so that the rounding errors of the product with the reciprocal
// (2^-23 of it) cannot make an integer quotient too small.
template <bool kLightness>
void from_hue_planes(const uint8_t* x, int64_t plane, int64_t n, uint8_t* out, int64_t out_plane) {
  const auto colour_of = [](auto d, const auto* from, auto* levels) {
    const auto whole = [=](float value) { return hn::Set(d, value); };
    auto hue = from[0];
    const auto second = from[1], third = from[2];
    hue = hn::IfThenElse(hn::Ge(hue, whole(180)), hn::Sub(hue, whole(180)), hue);
    // The distance of the hue from a channel's hue, in units of 1/30 of 60 degrees, limited to a ramp from 0
    // to 30.
    const auto apart = [=](float at) { return hn::Abs(hn::Sub(hue, whole(at))); };
    const auto limited = [=](auto part) { return hn::Min(hn::Max(part, hn::Zero(d)), whole(30)); };
    const hn::Vec<decltype(d)> parts[] = {limited(hn::Sub(whole(60), apart(90))),
                                          limited(hn::Sub(apart(60), whole(30))),
                                          limited(hn::Sub(apart(120), whole(30)))};
    for (int64_t c = 0; c < 3; ++c) {
      hn::Vec<decltype(d)> level;
      if constexpr (kLightness) {
        const auto room = hn::Mul(third, hn::Min(second, hn::Sub(whole(255), second)));
        level = hn::Mul(hn::Add(hn::Add(hn::Mul(second, whole(3825)), whole(1912.5f)),
                                hn::Mul(room, hn::Sub(whole(15), parts[c]))),
                        whole(1.0f / 3825));
      } else {
        const auto part = hn::Sub(whole(7650), hn::Mul(second, parts[c]));
        level = hn::Mul(hn::Add(hn::Mul(third, part), whole(3825.5f)), whole(1.0f / 7650));
      }
      levels[c] = hn::ConvertTo(Integers<decltype(d)>(), level);
    }
  };
  map_levels<3, 3>({x, x + plane, x + 2 * plane}, n, {out, out + out_plane, out + 2 * out_plane}, colour_of);
}

// Tables before, between and after two matrices, in integers.
struct Curves {
  const int32_t *first, *before, *middle, *after, *last;
  int64_t middles, lasts;
  int shift_before, shift_after;
};

// kLast: whether there is a last table; without it numbers from 0 to 255 are the bytes.
template <bool kLast>
void curve_planes(const uint8_t* x, int64_t plane, const Curves& curves, int64_t n, uint8_t* out,
                  int64_t out_plane) {
  for_lanes<int32_t>(n, [=](auto d, auto, int64_t k) {
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    hn::Vec<decltype(d)> channels[3], mixed[3];
    for (int64_t c = 0; c < 3; ++c)
      channels[c] =
          hn::GatherIndex(d, curves.first + 256 * c, hn::PromoteTo(d, hn::LoadU(bytes, x + c * plane + k)));
    const auto mix = [&](const int32_t* weights, int shift, int64_t entries) {
      for (int64_t r = 0; r < 3; ++r) {
        const auto product = [&](int64_t c) { return hn::Mul(channels[c], hn::Set(d, weights[4 * r + c])); };
        const auto sum =
            hn::Add(hn::Add(product(0), product(1)), hn::Add(product(2), hn::Set(d, weights[4 * r + 3])));
        const auto last = hn::Set(d, static_cast<int32_t>(entries - 1));
        mixed[r] = hn::Min(hn::Max(hn::ShiftRightSame(sum, shift), hn::Zero(d)), last);
      }
    };
    mix(curves.before, curves.shift_before, curves.middles);
    for (int64_t c = 0; c < 3; ++c) channels[c] = hn::GatherIndex(d, curves.middle, mixed[c]);
    mix(curves.after, curves.shift_after, curves.lasts);
    for (int64_t c = 0; c < 3; ++c) {
      if constexpr (kLast) mixed[c] = hn::GatherIndex(d, curves.last, mixed[c]);
      hn::StoreU(hn::DemoteTo(bytes, mixed[c]), bytes, out + c * out_plane + k);
    }
  });
}

}  // namespace

void mix_pixels(const uint8_t* x, int64_t n, int64_t values, const int32_t* weights, int64_t rows,
                int64_t shift, bool interleaved, uint8_t* out) {
  const float scale = 1.0f / static_cast<float>(int64_t{1} << shift);
  std::array<Mix, 3> mixes{};
  for (int64_t row = 0; row < rows; ++row) {
    Mix& mix = mixes[static_cast<size_t>(row)];
    std::copy_n(weights + 4 * row, 3, mix.weights);
    mix.offset = weights[4 * row + 3];
  }
  const bool words = rows == 1 && fits_words(mixes[0], shift);
  WordMix split{};
  const bool pairs = split_weights(mixes.data(), rows, split);
  for_planes(x, n, values / 3, rows, interleaved, out,
             [&](const uint8_t* from, int64_t plane, int64_t count, uint8_t* to, int64_t out_plane) {
               if (words)
                 mix_words(from, plane, mixes[0], shift, count, to);
               else if (pairs)
                 (rows == 1 ? mix_pairs<1> : mix_pairs<3>)(from, plane, split, shift, count, to, out_plane);
               else
                 (rows == 1 ? mix_planes<1> : mix_planes<3>)(from, plane, mixes.data(), scale, count, to,
                                                             out_plane);
             });
}

void luma_chroma_pixels(const uint8_t* x, int64_t n, int64_t values, int64_t red, int64_t green, int64_t blue,
                        int64_t first, int64_t second, bool interleaved, uint8_t* out) {
  const auto word = [](int64_t value) { return static_cast<int16_t>(value); };
  const LumaChroma mix{{word(red), word(green), word(blue)}, word(first), word(second)};
  for_planes(x, n, values / 3, 3, interleaved, out,
             [&](const uint8_t* from, int64_t plane, int64_t count, uint8_t* to, int64_t out_plane) {
               luma_chroma_planes(from, plane, mix, count, to, out_plane);
             });
}

void hue_pixels(const uint8_t* x, int64_t n, int64_t values, bool lightness, bool interleaved, uint8_t* out) {
  for_planes(x, n, values / 3, 3, interleaved, out,
             [&](const uint8_t* from, int64_t plane, int64_t count, uint8_t* to, int64_t out_plane) {
               (lightness ? hue_planes<true> : hue_planes<false>)(from, plane, count, to, out_plane);
             });
}

void from_hue_pixels(const uint8_t* x, int64_t n, int64_t values, bool lightness, bool interleaved,
                     uint8_t* out) {
  for_planes(x, n, values / 3, 3, interleaved, out,
             [&](const uint8_t* from, int64_t plane, int64_t count, uint8_t* to, int64_t out_plane) {
               (lightness ? from_hue_planes<true> : from_hue_planes<false>)(from, plane, count, to,
                                                                            out_plane);
             });
}

void curve_pixels(const uint8_t* x, int64_t n, int64_t values, const int32_t* first, const int32_t* before,
                  const int32_t* middle, int64_t middles, const int32_t* after, const int32_t* last,
                  int64_t lasts, int64_t shift_before, int64_t shift_after, bool interleaved, uint8_t* out) {
  const Curves curves{first,
                      before,
                      middle,
                      after,
                      last,
                      middles,
                      lasts,
                      static_cast<int>(shift_before),
                      static_cast<int>(shift_after)};
  bool straight = lasts == 256;
  for (int32_t i = 0; straight && i < 256; ++i) straight = last[i] == i;
  for_planes(x, n, values / 3, 3, interleaved, out,
             [&](const uint8_t* from, int64_t plane, int64_t count, uint8_t* to, int64_t out_plane) {
               (straight ? curve_planes<false> : curve_planes<true>)(from, plane, curves, count, to,
                                                                     out_plane);
             });
}

}  // namespace chiasm::kernels
