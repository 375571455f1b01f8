// Pixels whose channels lie next to each other: taken apart, put together, and mixed.
#include <array>

#include "rows.h"

namespace chiasm::kernels {
namespace {

// Values of one step: parts of an image that stay in L1, so that threads share one image.
constexpr int64_t kPart = 4096;

// Calls body(image, first, count) for runs of pixels of n images.
template <class Body>
void for_pixels(int64_t n, int64_t pixels, const Body& body) {
  const int64_t parts = (pixels + kPart - 1) / kPart;
#pragma omp parallel for
  for (int64_t i = 0; i < n * parts; ++i) {
    const int64_t first = i % parts * kPart;
    body(i / parts, first, std::min(kPart, pixels - first));
  }
}

template <int kChannels, class D, class T>
HWY_INLINE void load_pixels(D d, const T* p, hn::Vec<D>* channels) {
  if constexpr (kChannels == 2)
    hn::LoadInterleaved2(d, p, channels[0], channels[1]);
  else if constexpr (kChannels == 3)
    hn::LoadInterleaved3(d, p, channels[0], channels[1], channels[2]);
  else
    hn::LoadInterleaved4(d, p, channels[0], channels[1], channels[2], channels[3]);
}

template <int kChannels, class D, class T>
HWY_INLINE void store_pixels(D d, const hn::Vec<D>* channels, T* p) {
  if constexpr (kChannels == 2)
    hn::StoreInterleaved2(channels[0], channels[1], d, p);
  else if constexpr (kChannels == 3)
    hn::StoreInterleaved3(channels[0], channels[1], channels[2], d, p);
  else
    hn::StoreInterleaved4(channels[0], channels[1], channels[2], channels[3], d, p);
}

template <class T, int kChannels>
void split_run(const T* x, int64_t n, int64_t plane, T* out) {
  for_lanes<T>(n, [=](auto d, auto, int64_t k) {
    if constexpr (hn::MaxLanes(d) == 1) {
      for (int c = 0; c < kChannels; ++c) out[c * plane + k] = x[kChannels * k + c];
    } else {
      hn::Vec<decltype(d)> channels[kChannels];
      load_pixels<kChannels>(d, x + kChannels * k, channels);
      for (int c = 0; c < kChannels; ++c) hn::StoreU(channels[c], d, out + c * plane + k);
    }
  });
}

template <class T, int kChannels>
void join_run(const T* x, int64_t n, int64_t plane, T* out) {
  for_lanes<T>(n, [=](auto d, auto, int64_t k) {
    if constexpr (hn::MaxLanes(d) == 1) {
      for (int c = 0; c < kChannels; ++c) out[kChannels * k + c] = x[c * plane + k];
    } else {
      hn::Vec<decltype(d)> channels[kChannels];
      for (int c = 0; c < kChannels; ++c) channels[c] = hn::LoadU(d, x + c * plane + k);
      store_pixels<kChannels>(d, channels, out + kChannels * k);
    }
  });
}

}  // namespace

template <class P>
void split_pixels(const P* x, int64_t n, int64_t values, int64_t channels, P* out) {
  const int64_t plane = values / channels;
  for_pixels(n, plane, [&](int64_t image, int64_t first, int64_t count) {
    const P* const from = x + image * values + first * channels;
    P* const to = out + image * values + first;
    switch (channels) {
      case 2: return split_run<P, 2>(from, count, plane, to);
      case 3: return split_run<P, 3>(from, count, plane, to);
      case 4: return split_run<P, 4>(from, count, plane, to);
      default: break;
    }
    for (int64_t c = 0; c < channels; ++c)
      for (int64_t k = 0; k < count; ++k) to[c * plane + k] = from[k * channels + c];
  });
}

template <class P>
void join_pixels(const P* x, int64_t n, int64_t values, int64_t channels, P* out) {
  const int64_t plane = values / channels;
  for_pixels(n, plane, [&](int64_t image, int64_t first, int64_t count) {
    const P* const from = x + image * values + first;
    P* const to = out + image * values + first * channels;
    switch (channels) {
      case 2: return join_run<P, 2>(from, count, plane, to);
      case 3: return join_run<P, 3>(from, count, plane, to);
      case 4: return join_run<P, 4>(from, count, plane, to);
      default: break;
    }
    for (int64_t k = 0; k < count; ++k)
      for (int64_t c = 0; c < channels; ++c) to[k * channels + c] = from[c * plane + k];
  });
}

namespace {

// One channel of what is mixed: weights of the three channels, and what is added before the shift.
struct Mix {
  int32_t weights[3], offset;
};

// Bytes as numbers.
template <class D>
HWY_INLINE hn::Vec<D> number(D numbers, const uint8_t* x) {
  const hn::Rebind<uint8_t, D> bytes;
  return hn::ConvertTo(numbers, hn::PromoteTo(Integers<D>(), hn::LoadU(bytes, x)));
}

// Numbers from 0 to 255 that have been rounded, and others saturated.
template <class D>
HWY_INLINE void store_levels(D, hn::Vec<Integers<D>> levels, uint8_t* out) {
  const hn::Rebind<uint8_t, D> bytes;
  hn::StoreU(hn::DemoteTo(bytes, levels), bytes, out);
}

// kRows sums of three planes of n bytes, `plane` bytes apart. Products of weights and bytes are whole numbers
// that float32 holds, and a product of float32 is one instruction where that of int32 is two.
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
        // Below 0 everything becomes 0, so that to truncate is to round down.
        store_levels(d, hn::ConvertTo(Integers<decltype(d)>(), hn::Mul(sum, hn::Set(d, scale))),
                     out + r * out_plane + k + v * lanes);
      }
    }
  });
}

// The same where no weight is below 0 and their high and their low bytes have sums of 16 bits: both are
// weighted apart, twice as many values in a vector.
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

// Calls body(planes, plane, count, out, out_plane) for runs of pixels of images of three channels: planes of
// `count` bytes, `plane` bytes apart, of which `out` gets `rows` planes. Interleaved pixels are taken apart,
// and three planes put together, in L1.
template <class Body>
void for_planes(const uint8_t* x, int64_t n, int64_t pixels, int64_t rows, bool interleaved, uint8_t* out,
                const Body& body) {
  for_pixels(n, pixels, [&](int64_t image, int64_t first, int64_t count) {
    const uint8_t* const from = x + image * 3 * pixels;
    uint8_t* const to = out + image * rows * pixels;
    if (!interleaved) return body(from + first, pixels, count, to + first, pixels);
    alignas(kLine) std::array<uint8_t, 3 * kPart> planes, made;
    split_run<uint8_t, 3>(from + 3 * first, count, kPart, planes.data());
    if (rows == 1) return body(planes.data(), kPart, count, to + first, pixels);
    body(planes.data(), kPart, count, made.data(), kPart);
    join_run<uint8_t, 3>(made.data(), count, kPart, to + 3 * first);
  });
}

// Hue in degrees / 2, saturation and value, 0 to 255, rounded halves to even. Quotients are of whole numbers
// below 2^16: those that are no halves are further from them than float32 rounds.
void hsv_planes(const uint8_t* x, int64_t plane, int64_t n, uint8_t* out, int64_t out_plane) {
  for_lanes<float, 2>(n, [=](auto d, auto vectors, int64_t k) {
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    const auto whole = [=](float value) { return hn::Set(d, value); };
    for (int v = 0; v < vectors; ++v) {
      const uint8_t* const p = x + k + v * lanes;
      uint8_t* const to = out + k + v * lanes;
      const auto r = number(d, p), g = number(d, p + plane), b = number(d, p + 2 * plane);
      const auto value = hn::Max(hn::Max(r, g), b), chroma = hn::Sub(value, hn::Min(hn::Min(r, g), b));
      const auto is_red = hn::Eq(value, r), is_green = hn::Eq(value, g);
      const auto turn =
          hn::IfThenElse(is_red, hn::Sub(g, b),
                         hn::Add(hn::IfThenElse(is_green, hn::Sub(b, r), hn::Sub(r, g)),
                                 hn::Mul(chroma, hn::IfThenElse(is_green, whole(2), whole(4)))));
      const auto hue = hn::Div(hn::Mul(whole(30), turn), hn::Max(chroma, whole(1)));
      const auto saturation = hn::Div(hn::Mul(whole(255), chroma), hn::Max(value, whole(1)));
      const auto degrees = hn::NearestInt(hue);
      const Integers<decltype(d)> integers;
      const auto turned = hn::Add(degrees, hn::Set(integers, 180));
      store_levels(d, hn::IfThenElse(hn::Lt(degrees, hn::Zero(integers)), turned, degrees), to);
      store_levels(d, hn::NearestInt(saturation), to + out_plane);
      store_levels(d, hn::NearestInt(value), to + 2 * out_plane);
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
  for_planes(x, n, values / 3, rows, interleaved, out,
             [&](const uint8_t* from, int64_t plane, int64_t count, uint8_t* to, int64_t out_plane) {
               if (words)
                 mix_words(from, plane, mixes[0], shift, count, to);
               else
                 (rows == 1 ? mix_planes<1> : mix_planes<3>)(from, plane, mixes.data(), scale, count, to,
                                                             out_plane);
             });
}

void hsv_pixels(const uint8_t* x, int64_t n, int64_t values, bool interleaved, uint8_t* out) {
  for_planes(x, n, values / 3, 3, interleaved, out,
             [](const uint8_t* from, int64_t plane, int64_t count, uint8_t* to, int64_t out_plane) {
               hsv_planes(from, plane, count, to, out_plane);
             });
}

CHIASM_INSTANTIATE(split_pixels)
CHIASM_INSTANTIATE(join_pixels)

}  // namespace chiasm::kernels
