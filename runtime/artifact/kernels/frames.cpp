// Interleaved bytes of a camera's frame, pixels B, G, R, as numbers.
#include <cstring>

#include "declared/frames.h"
#include "resize_taps.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

constexpr int64_t kBlock = 8192;

// The numbers at `channel` of a vector of pixels: a shuffle puts every third byte where an integer of 32 bits
// has its lowest.
template <class D, class Pixels>
HWY_INLINE hn::Vec<D> numbers(D d, Pixels pixels, int channel) {
  alignas(16) uint8_t lanes[16];
  for (int i = 0; i < 16; ++i) lanes[i] = static_cast<uint8_t>(i % 4 ? 0x80 : i / 4 * 3 + channel);
  const hn::Repartition<uint8_t, D> bytes;
  return hn::ConvertTo(
      d, hn::BitCast(Integers<D>(), hn::TableLookupBytesOr0(pixels, hn::LoadDup128(bytes, lanes))));
}

// For each pixel of the output, the pixel of a row and its right neighbour that are summed: the weight of the
// first one, three times, and that of the second one.
struct Pairs {
  std::vector<int64_t> first;  // in bytes
  std::vector<float> weights;  // four for each of the two pixels, the last one 0
  int64_t inside = 0;          // how many pairs have eight bytes in a row
};

Pairs pairs_of(const Taps<float>& taps, int64_t width) {
  Pairs pairs{std::vector<int64_t>(taps.count), std::vector<float>(8 * taps.count), 0};
  for (int64_t i = 0; i < taps.count; ++i) {
    const int64_t first = std::min<int64_t>(taps.index[2 * i], width - 2);
    pairs.first[i] = 3 * first;
    if (3 * first + 8 <= 3 * width) pairs.inside = i + 1;
    for (int64_t k = 0; k < 2; ++k)  // at the ends of a row, both taps read one pixel
      for (int64_t channel = 0; channel < 3; ++channel)
        pairs.weights[8 * i + 4 * (taps.index[2 * i + k] - first) + channel] += taps.weight[2 * i + k];
  }
  return pairs;
}

// Two pixels as four numbers each, of which three are used: in one vector of eight, or in two of four.
using Part = hn::CappedTag<float, 8>;
constexpr int64_t kParts = 8 / static_cast<int64_t>(hn::MaxLanes(Part()));
static_assert(kParts == 1 || kParts == 2);

template <bool kEnd>
HWY_INLINE void load_pair(const uint8_t* p, hn::Vec<Part>* pixels) {
  uint64_t eight = 0;  // or six at the end of the frame, because nothing may be read beyond it
  std::memcpy(&eight, p, kEnd ? 6 : 8);
  const Part d;
  const hn::Repartition<uint64_t, Part> words;
  const hn::Repartition<uint8_t, Part> bytes;
  for (int64_t i = 0; i < kParts; ++i) {
    alignas(32) uint8_t lanes[32];
    for (int64_t k = 0; k < 32; ++k)
      lanes[k] = static_cast<uint8_t>(k % 4 ? 0x80 : 3 * (i + k / 16) + k / 4 % 4);
    pixels[i] = hn::ConvertTo(
        d, hn::BitCast(Integers<Part>(), hn::TableLookupBytesOr0(hn::BitCast(bytes, hn::Set(words, eight)),
                                                                 hn::LoadU(bytes, lanes))));
  }
}

template <class D>
HWY_INLINE hn::Vec<hn::FixedTag<float, 4>> sum_of_pair(D, const hn::Vec<D>* pixels) {
  const hn::Half<D> half;
  if constexpr (kParts == 1)
    return hn::Add(hn::LowerHalf(half, pixels[0]), hn::UpperHalf(half, pixels[0]));
  else
    return hn::Add(pixels[0], pixels[1]);
}

}  // namespace

void frame_to_grey(const uint8_t* frame, int64_t height, int64_t width, float* out) {
  const int64_t n = height * width;
  const auto luma = [](auto d, auto b, auto g, auto r) {
    return hn::Add(hn::Add(hn::Mul(r, hn::Set(d, 0.299f)), hn::Mul(g, hn::Set(d, 0.587f))),
                   hn::Mul(b, hn::Set(d, 0.114f)));
  };
#pragma omp parallel for
  for (int64_t begin = 0; begin < n; begin += kBlock) {
    const int64_t end = std::min(begin + kBlock, n);
    int64_t i = begin;
    // Of every 16 bytes that are loaded, 12 belong to four pixels.
    for (; i + kLanes<float> <= end && 3 * (i + kLanes<float>)+4 <= 3 * n; i += kLanes<float>) {
      const Lanes<float> d;
      const hn::FixedTag<uint8_t, 16> block;
      const uint8_t* const p = frame + 3 * i;
      const auto pixels = combined<decltype(block)>(hn::Repartition<uint8_t, Lanes<float>>(), [=](int64_t k) {
        return hn::LoadU(block, p + k / 16 * 12);
      });
      hn::StoreU(luma(d, numbers(d, pixels, 0), numbers(d, pixels, 1), numbers(d, pixels, 2)), d, out + i);
    }
    for (; i < end; ++i) {
      const Lane<float> d;
      const auto number = [=](int64_t channel) {
        return hn::Set(d, static_cast<float>(frame[3 * i + channel]));
      };
      hn::StoreU(luma(d, number(0), number(1), number(2)), d, out + i);
    }
  }
}

void resize_frame(const uint8_t* frame, int64_t height, int64_t width, int64_t new_height, int64_t new_width,
                  float* out) {
  const Taps<float> down = resize_taps<float>(height, new_height, Interpolation::kBilinear, false, false);
  const Pairs across =
      pairs_of(resize_taps<float>(width, new_width, Interpolation::kBilinear, false, false), width);
  const int64_t room = (new_width + 3) / 4 * 16;
  std::vector<float> all_rows(static_cast<size_t>(room * omp_get_max_threads()));
#pragma omp parallel for
  for (int64_t y = 0; y < new_height; ++y) {
    const uint8_t *const upper = frame + 3 * width * down.index[2 * y], *const lower =
                                                                            frame +
                                                                            3 * width * down.index[2 * y + 1];
    const Part d;
    const auto above = hn::Set(d, down.weight[2 * y]), below = hn::Set(d, down.weight[2 * y + 1]);
    float* const row = all_rows.data() + room * omp_get_thread_num();  // four numbers a pixel
    const int64_t* const first = across.first.data();
    const float* const weights = across.weights.data();
    const auto sum = [=](int64_t x, auto end) {
      hn::Vec<Part> a[kParts], b[kParts];
      load_pair<end>(upper + first[x], a);
      load_pair<end>(lower + first[x], b);
      for (int64_t i = 0; i < kParts; ++i)
        a[i] = hn::Mul(hn::Add(hn::Mul(a[i], above), hn::Mul(b[i], below)),
                       hn::LoadU(d, weights + 8 * x + 4 * i));
      hn::StoreU(sum_of_pair(d, a), hn::FixedTag<float, 4>(), row + 4 * x);
    };
    int64_t x = 0;
    for (; x < across.inside; ++x) sum(x, std::false_type());
    for (; x < new_width; ++x) sum(x, std::true_type());
    float *const blue = out + (2 * new_height + y) * new_width,
                 *const green = out + (new_height + y) * new_width, *const red = out + y * new_width;
    for_lanes<float>(new_width, [=](auto tag, auto, int64_t k) {
      hn::Vec<decltype(tag)> b, g, r, rest;
      hn::LoadInterleaved4(tag, row + 4 * k, b, g, r, rest);
      hn::StoreU(b, tag, blue + k);
      hn::StoreU(g, tag, green + k);
      hn::StoreU(r, tag, red + k);
    });
  }
}

}  // namespace chiasm::kernels
