// Runs of interleaved pixels, and of planes.
#pragma once

#include <array>

#include "rows.h"

namespace chiasm::kernels {

// Values of one part. Images are split into parts that stay in L1 and that threads share.
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

// Bytes as numbers.
template <class D>
HWY_INLINE hn::Vec<D> number(D numbers, const uint8_t* x) {
  const hn::Rebind<uint8_t, D> bytes;
  return hn::ConvertTo(numbers, hn::PromoteTo(Integers<D>(), hn::LoadU(bytes, x)));
}

// The whole number nearest to one from 0 to 255, half to even: from 2^23 on, float32 has no fractions.
template <class D>
HWY_INLINE hn::Vec<Integers<D>> nearest_level(D d, hn::Vec<D> value) {
  const Integers<D> integers;
  return hn::And(hn::BitCast(integers, hn::Add(value, hn::Set(d, 8388608.0f))), hn::Set(integers, 255));
}

// Calls body(d, numbers, levels) for vectors of numbers, one from each of the `from`, and stores the levels,
// 0 to 255. A vector has every fourth byte of four vectors' worth: bytes are taken out of words of 32 bits
// and put back by shifts, which avoids shuffles, because these have a lower throughput.
template <int kFrom, int kTo, class Body>
HWY_INLINE void map_levels(const std::array<const uint8_t*, kFrom>& from, int64_t n,
                           const std::array<uint8_t*, kTo>& to, const Body& body) {
  for_lanes<float, 4>(n, [&](auto d, auto vectors, int64_t k) {
    const Integers<decltype(d)> integers;
    hn::Vec<decltype(d)> numbers[kFrom];
    hn::Vec<decltype(integers)> levels[kTo];
    if constexpr (vectors == 4) {
      const hn::Repartition<uint8_t, decltype(d)> bytes;
      const hn::RebindToUnsigned<decltype(d)> words;
      hn::Vec<decltype(words)> read[kFrom], made[kTo];
      for (int i = 0; i < kFrom; ++i)
        read[i] = hn::BitCast(words, hn::LoadU(bytes, from[static_cast<size_t>(i)] + k));
      for (auto& v : made) v = hn::Zero(words);
      const auto take = [&](auto byte) {
        constexpr int kShift = 8 * byte;
        for (int i = 0; i < kFrom; ++i) {
          const auto level = hn::And(hn::ShiftRight<kShift>(read[i]), hn::Set(words, 255));
          numbers[i] = hn::ConvertTo(d, hn::BitCast(integers, level));
        }
        body(d, numbers, levels);
        for (int i = 0; i < kTo; ++i)
          made[i] = hn::Or(made[i], hn::ShiftLeft<kShift>(hn::BitCast(words, levels[i])));
      };
      take(std::integral_constant<int, 0>());
      take(std::integral_constant<int, 1>());
      take(std::integral_constant<int, 2>());
      take(std::integral_constant<int, 3>());
      for (int i = 0; i < kTo; ++i)
        hn::StoreU(hn::BitCast(bytes, made[i]), bytes, to[static_cast<size_t>(i)] + k);
    } else {
      const hn::Rebind<uint8_t, decltype(d)> bytes;
      for (int i = 0; i < kFrom; ++i) numbers[i] = number(d, from[static_cast<size_t>(i)] + k);
      body(d, numbers, levels);
      for (int i = 0; i < kTo; ++i)
        hn::StoreU(hn::DemoteTo(bytes, levels[i]), bytes, to[static_cast<size_t>(i)] + k);
    }
  });
}

template <int kChannels, class D, class T>
HWY_INLINE void load_pixels(D d, const T* p, hn::Vec<D>* channels) {
  if constexpr (kChannels == 1)
    channels[0] = hn::LoadU(d, p);
  else if constexpr (kChannels == 2)
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

template <class T>
void split_channels(const T* x, int64_t n, int64_t channels, int64_t plane, T* out) {
  switch (channels) {
    case 2: return split_run<T, 2>(x, n, plane, out);
    case 3: return split_run<T, 3>(x, n, plane, out);
    case 4: return split_run<T, 4>(x, n, plane, out);
    default: break;
  }
  for (int64_t c = 0; c < channels; ++c)
    for (int64_t k = 0; k < n; ++k) out[c * plane + k] = x[k * channels + c];
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

// Calls body(planes, plane, count, out, out_plane) for runs of pixels of images of three channels: planes of
// `count` bytes, `plane` bytes apart; `out` gets `rows` planes. Interleaved pixels are split into planes, and
// three planes interleaved, in L1.
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

}  // namespace chiasm::kernels
