// Interleaved pixels: split into planes, interleaved from planes, and rearranged.
#include <array>

#include "declared/pixels.h"
#include "interleaving.h"
#include "pixels.h"

namespace chiasm::kernels {
namespace {

// Pixels with kMade channels; each is one of the kChannels input channels, or the fill value.
template <class T, int kChannels, int kMade>
void arrange_run(const T* x, int64_t n, const std::array<int32_t, 4>& order, T fill, T* out) {
  for_lanes<T>(n, [=](auto d, auto, int64_t k) {
    if constexpr (hn::MaxLanes(d) == 1) {
      for (size_t c = 0; c < kMade; ++c)
        out[kMade * k + static_cast<int64_t>(c)] = order[c] < 0 ? fill : x[kChannels * k + order[c]];
    } else {
      hn::Vec<decltype(d)> channels[kChannels], made[kMade];
      load_pixels<kChannels>(d, x + kChannels * k, channels);
      for (size_t c = 0; c < kMade; ++c) {
        made[c] = hn::Set(d, fill);
        for (int i = 0; i < kChannels; ++i)
          if (order[c] == i) made[c] = channels[i];
      }
      store_pixels<kMade>(d, made, out + kMade * k);
    }
  });
}

template <class T, int kChannels>
bool arrange_run(const T* x, int64_t n, const std::array<int32_t, 4>& order, int64_t made, T fill, T* out) {
  if (made == 3) return arrange_run<T, kChannels, 3>(x, n, order, fill, out), true;
  if (made == 4) return arrange_run<T, kChannels, 4>(x, n, order, fill, out), true;
  return false;
}

}  // namespace

template <class P>
void arrange_pixels(const P* x, int64_t n, int64_t values, const int32_t* order, int64_t made,
                    int64_t channels, double fill, P* out) {
  const int64_t pixels = values / channels;
  const auto filled = as_pixel<P>(fill);
  std::array<int32_t, 4> first{};
  for (int64_t c = 0; c < std::min<int64_t>(made, 4); ++c)
    first[static_cast<size_t>(c)] = order[c] < channels ? order[c] : -1;
  for_pixels(n, pixels, [&](int64_t image, int64_t start, int64_t count) {
    const P* const from = x + image * values + start * channels;
    P* const to = out + (image * pixels + start) * made;
    if (channels == 1 && arrange_run<P, 1>(from, count, first, made, filled, to)) return;
    if (channels == 3 && arrange_run<P, 3>(from, count, first, made, filled, to)) return;
    if (channels == 4 && arrange_run<P, 4>(from, count, first, made, filled, to)) return;
    for (int64_t k = 0; k < count; ++k)
      for (int64_t c = 0; c < made; ++c)
        to[k * made + c] = order[c] < 0 || order[c] >= channels ? filled : from[k * channels + order[c]];
  });
}

template <class A>
void split_pixels(const A* x, int64_t n, int64_t values, int64_t channels, A* out) {
  const int64_t plane = values / channels;
  for_pixels(n, plane, [&](int64_t image, int64_t first, int64_t count) {
    const A* const from = x + image * values + first * channels;
    A* const to = out + image * values + first;
    split_channels(from, count, channels, plane, to);
  });
}

template <class A>
void join_pixels(const A* x, int64_t n, int64_t values, int64_t channels, A* out) {
  const int64_t plane = values / channels;
  for_pixels(n, plane, [&](int64_t image, int64_t first, int64_t count) {
    const A* const from = x + image * values + first;
    A* const to = out + image * values + first * channels;
    switch (channels) {
      case 2: return join_run<A, 2>(from, count, plane, to);
      case 3: return join_run<A, 3>(from, count, plane, to);
      case 4: return join_run<A, 4>(from, count, plane, to);
      default: break;
    }
    for (int64_t k = 0; k < count; ++k)
      for (int64_t c = 0; c < channels; ++c) to[k * channels + c] = from[c * plane + k];
  });
}

CHIASM_INSTANTIATE(arrange_pixels)
CHIASM_INSTANTIATE(split_pixels)
CHIASM_INSTANTIATE(join_pixels)

}  // namespace chiasm::kernels
