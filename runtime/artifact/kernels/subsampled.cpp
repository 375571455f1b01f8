// RGB of luma and chroma in bytes, where pixels share their chroma: what cameras and decoders give.
#include <algorithm>

#include "interleaving.h"

namespace chiasm::kernels {
namespace {

// Factors in 1/2^20, and the luma of black.
struct Factors {
  int32_t luma, red, green_u, green_v, blue, black;

  explicit Factors(const int32_t* w)
      : luma(w[0]), red(w[1]), green_u(w[2]), green_v(w[3]), blue(w[4]), black(w[5]) {}
};

constexpr int kShift = 20;
constexpr int32_t kHalf = 1 << (kShift - 1);

// What chroma, less 128, adds to the three colours, with a half for rounding; and with it their levels.
template <class D>
struct Colours {
  hn::Vec<D> parts[3];

  HWY_INLINE Colours(D d, const Factors& f, hn::Vec<D> u, hn::Vec<D> v) {
    const auto times = [=](hn::Vec<D> x, int32_t factor) { return hn::Mul(x, hn::Set(d, factor)); };
    const auto half = hn::Set(d, kHalf);
    parts[0] = hn::Add(times(v, f.red), half);
    parts[1] = hn::Add(hn::Add(times(u, f.green_u), times(v, f.green_v)), half);
    parts[2] = hn::Add(times(u, f.blue), half);
  }

  HWY_INLINE hn::Vec<D> bright(D d, const Factors& f, hn::Vec<D> luma) const {
    return hn::Mul(hn::Max(hn::Sub(luma, hn::Set(d, f.black)), hn::Zero(d)), hn::Set(d, f.luma));
  }

  HWY_INLINE hn::Vec<D> level(D d, int c, hn::Vec<D> bright) const {
    const auto sum = hn::ShiftRight<kShift>(hn::Add(bright, parts[c]));
    return hn::Min(hn::Max(sum, hn::Zero(d)), hn::Set(d, 255));
  }
};

// One pixel at `out`, `plane` bytes from one colour to the next.
void one_pixel(const Factors& f, int32_t luma, int32_t u, int32_t v, uint8_t* out, int64_t plane) {
  const hn::CappedTag<int32_t, 1> d;
  const Colours<decltype(d)> colours(d, f, hn::Set(d, u - 128), hn::Set(d, v - 128));
  const auto bright = colours.bright(d, f, hn::Set(d, luma));
  for (int c = 0; c < 3; ++c) out[c * plane] = static_cast<uint8_t>(hn::GetLane(colours.level(d, c, bright)));
}

// Both luma of a pair of pixels, and their U and V.
template <class D>
struct Pairs {
  hn::Vec<D> even, odd, u, v;
};

// Pairs of bytes as numbers, the first and the second ones: of every 16 bits the low and the high half.
template <class D>
HWY_INLINE void both_of(D d, const uint8_t* p, hn::Vec<D>& first, hn::Vec<D>& second) {
  const hn::Rebind<uint16_t, D> words;
  const auto wide = hn::PromoteTo(d, hn::LoadU(words, reinterpret_cast<const uint16_t*>(p)));
  first = hn::And(wide, hn::Set(d, 255));
  second = hn::ShiftRight<8>(wide);
}

// Where the values of pairs of pixels lie.
template <bool kSwapped>
struct Planar {
  const uint8_t *luma, *chroma;

  template <class D>
  HWY_INLINE Pairs<D> load(D d, int64_t k) const {
    Pairs<D> pairs;
    both_of(d, luma + 2 * k, pairs.even, pairs.odd);
    both_of(d, chroma + 2 * k, kSwapped ? pairs.v : pairs.u, kSwapped ? pairs.u : pairs.v);
    return pairs;
  }
};

template <bool kLumaFirst>
struct Packed {
  const uint8_t* pixels;

  template <class D>
  HWY_INLINE Pairs<D> load(D d, int64_t k) const {
    const hn::RebindToUnsigned<D> bits;
    const auto x = hn::BitCast(bits, hn::LoadU(d, reinterpret_cast<const int32_t*>(pixels + 4 * k)));
    const auto byte = [=](auto shifted) {
      return hn::BitCast(d, hn::And(shifted, hn::Set(bits, uint32_t{255})));
    };
    const auto first = byte(x), second = byte(hn::ShiftRight<8>(x)), third = byte(hn::ShiftRight<16>(x)),
               last = byte(hn::ShiftRight<24>(x));
    return kLumaFirst ? Pairs<D>{first, third, second, last} : Pairs<D>{second, last, first, third};
  }
};

// n pairs of pixels to planes of red, green and blue.
template <class Source>
void run_of_pairs(const Source& source, const Factors& factors, int64_t n, uint8_t* out, int64_t plane) {
  for_lanes<int32_t>(n, [=](auto d, auto, int64_t k) {
    using D = decltype(d);
    const Pairs<D> pairs = source.load(d, k);
    const auto around = hn::Set(d, 128);
    const Colours<D> colours(d, factors, hn::Sub(pairs.u, around), hn::Sub(pairs.v, around));
    const auto even = colours.bright(d, factors, pairs.even), odd = colours.bright(d, factors, pairs.odd);
    const hn::Rebind<uint16_t, D> words;
    for (int c = 0; c < 3; ++c) {
      const auto both = hn::Or(colours.level(d, c, even), hn::ShiftLeft<8>(colours.level(d, c, odd)));
      hn::StoreU(hn::DemoteTo(words, both), words, reinterpret_cast<uint16_t*>(out + c * plane + 2 * k));
    }
  });
}

// Calls run(first, count, planes, plane) for parts of a row of pixels, each from an even one on, and has what it
// makes in frames, or in planes.
template <class Run>
void row_of_pixels(int64_t width, bool interleaved, uint8_t* out, int64_t out_plane, const Run& run) {
  uint8_t planes[3 * kPart];
  for (int64_t first = 0; first < width; first += kPart) {
    const int64_t count = std::min(kPart, width - first);
    if (interleaved) {
      run(first, count, planes, kPart);
      join_run<uint8_t, 3>(planes, count, kPart, out + 3 * first);
    } else {
      run(first, count, out + first, out_plane);
    }
  }
}

}  // namespace

void subsampled_pixels(const uint8_t* luma, int64_t n, int64_t height, int64_t width, const uint8_t* chroma,
                       int64_t rows, int64_t values, const int32_t* weights, bool swapped, bool interleaved,
                       uint8_t* out) {
  const Factors factors(weights);
  const int64_t columns = values / 2, plane = height * width;
#pragma omp parallel for
  for (int64_t i = 0; i < n * height; ++i) {
    const int64_t image = i / height, y = i % height;
    const uint8_t* const from = luma + i * width;
    const uint8_t* const shared = chroma + (image * rows + y * rows / height) * values;
    uint8_t* const to = out + (interleaved ? 3 * i * width : 3 * image * plane + y * width);
    row_of_pixels(width, interleaved, to, plane,
                  [&](int64_t first, int64_t count, uint8_t* made, int64_t made_plane) {
                    // Of a pair with one chroma, all are a whole pair but the last pixel of an odd width.
                    int64_t pairs = 0;
                    if (columns == (width + 1) / 2) {
                      pairs = count / 2;
                      const uint8_t *const bright = from + first, *const pair = shared + first;
                      if (swapped)
                        run_of_pairs(Planar<true>{bright, pair}, factors, pairs, made, made_plane);
                      else
                        run_of_pairs(Planar<false>{bright, pair}, factors, pairs, made, made_plane);
                    }
                    for (int64_t k = 2 * pairs; k < count; ++k) {
                      const uint8_t* const c = shared + (first + k) * columns / width * 2;
                      one_pixel(factors, from[first + k], c[swapped], c[!swapped], made + k, made_plane);
                    }
                  });
  }
}

void packed_pixels(const uint8_t* x, int64_t n, int64_t height, int64_t values, const int32_t* weights,
                   bool luma_first, uint8_t* out) {
  const Factors factors(weights);
  const int64_t width = values / 2;
#pragma omp parallel for
  for (int64_t i = 0; i < n * height; ++i)
    row_of_pixels(width, true, out + 3 * i * width, 0,
                  [&](int64_t first, int64_t count, uint8_t* made, int64_t plane) {
                    const uint8_t* const from = x + i * values + 2 * first;
                    if (luma_first)
                      run_of_pairs(Packed<true>{from}, factors, count / 2, made, plane);
                    else
                      run_of_pairs(Packed<false>{from}, factors, count / 2, made, plane);
                  });
}

}  // namespace chiasm::kernels
