// RGB from luma and subsampled chroma in bytes, as cameras and decoders deliver them; and the inverse, for
// encoders.
#include <algorithm>
#include <type_traits>
#include <utility>

#include "declared/subsampled.h"
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

// The amounts that chroma, minus 128, adds to the three colours, with a half for rounding; and the resulting
// levels.
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

// Both luma of a pair of pixels, and its U and V.
template <class D>
struct Pairs {
  hn::Vec<D> even, odd, u, v;
};

// Pairs of bytes as numbers, first and second bytes separately: the low and the high half of every 16 bits.
template <class D>
HWY_INLINE void both_of(D d, const uint8_t* p, hn::Vec<D>& first, hn::Vec<D>& second) {
  const hn::Rebind<uint16_t, D> words;
  const auto wide = hn::PromoteTo(d, hn::LoadU(words, reinterpret_cast<const uint16_t*>(p)));
  first = hn::And(wide, hn::Set(d, 255));
  second = hn::ShiftRight<8>(wide);
}

// Where the values of pairs of pixels are: with pairs of chroma.
template <bool kSwapped>
struct Interleaved {
  const uint8_t *luma, *chroma;

  template <class D>
  HWY_INLINE Pairs<D> load(D d, int64_t k) const {
    Pairs<D> pairs;
    both_of(d, luma + 2 * k, pairs.even, pairs.odd);
    both_of(d, chroma + 2 * k, kSwapped ? pairs.v : pairs.u, kSwapped ? pairs.u : pairs.v);
    return pairs;
  }
};

// With U and V in planes of their own.
struct Split {
  const uint8_t *luma, *u, *v;

  template <class D>
  HWY_INLINE Pairs<D> load(D d, int64_t k) const {
    Pairs<D> pairs;
    both_of(d, luma + 2 * k, pairs.even, pairs.odd);
    const hn::Rebind<uint8_t, D> bytes;
    pairs.u = hn::PromoteTo(d, hn::LoadU(bytes, u + k));
    pairs.v = hn::PromoteTo(d, hn::LoadU(bytes, v + k));
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

// Calls run(first, count, planes, plane) for parts of a row of pixels, each of which begins at an even pixel,
// and stores the results as frames or planes.
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

// The images of luma, and the size of their chroma.
struct Subsampled {
  const uint8_t* luma;
  int64_t n, height, width, rows, columns;
};

// To RGB, with chroma of any size. For a pixel at `first` in a row of luma, and a row of chroma counted over
// all images, pairs_at(luma, row, first) is what run_of_pairs reads where each pair of pixels has a chroma of
// its own; u_and_v(row, column) is a single chroma.
template <class PairsAt, class Chroma>
void to_rgb(const Subsampled& x, const Factors& factors, bool interleaved, uint8_t* out,
            const PairsAt& pairs_at, const Chroma& u_and_v) {
  const int64_t width = x.width, plane = x.height * width;
#pragma omp parallel for
  for (int64_t i = 0; i < x.n * x.height; ++i) {
    const int64_t image = i / x.height, y = i % x.height, row = image * x.rows + y * x.rows / x.height;
    const uint8_t* const luma = x.luma + i * width;
    uint8_t* const to = out + (interleaved ? 3 * i * width : 3 * image * plane + y * width);
    row_of_pixels(width, interleaved, to, plane,
                  [&](int64_t first, int64_t count, uint8_t* made, int64_t made_plane) {
                    // All pairs with one chroma have two pixels, except the last one of an odd width.
                    const int64_t pairs = x.columns == (width + 1) / 2 ? count / 2 : 0;
                    run_of_pairs(pairs_at(luma + first, row, first), factors, pairs, made, made_plane);
                    for (int64_t k = 2 * pairs; k < count; ++k) {
                      const auto [u, v] = u_and_v(row, (first + k) * x.columns / width);
                      one_pixel(factors, luma[first + k], u, v, made + k, made_plane);
                    }
                  });
  }
}

// The sum of three numbers by weights in 1/2^shift, plus an offset, without its fraction.
template <int kShift, class D>
HWY_INLINE hn::Vec<D> mixed(D d, const hn::Vec<D>* x, const int32_t* weights, int32_t offset) {
  auto sum = hn::Set(d, offset);
  for (int c = 0; c < 3; ++c) sum = hn::Add(sum, hn::Mul(x[c], hn::Set(d, weights[c])));
  return hn::Min(hn::Max(hn::ShiftRight<kShift>(sum), hn::Zero(d)), hn::Set(d, 255));
}

struct ChromaWeights {
  int32_t luma[3], first[3], second[3], luma_offset, chroma_offset;

  explicit ChromaWeights(const int32_t* w)
      : luma_offset(static_cast<int32_t>((2 * int64_t{w[9]} + 1) * kHalf)),
        chroma_offset((2 * 128 + 1) * (1 << (kShift + 1))) {
    std::copy_n(w, 3, luma);
    std::copy_n(w + 3, 3, first);
    std::copy_n(w + 6, 3, second);
  }
};

void luma_of(const uint8_t* x, int64_t plane, const ChromaWeights& weights, int64_t n, uint8_t* out) {
  for_lanes<int32_t>(n, [=](auto d, auto, int64_t k) {
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    hn::Vec<decltype(d)> levels[3];
    for (int c = 0; c < 3; ++c) levels[c] = hn::PromoteTo(d, hn::LoadU(bytes, x + c * plane + k));
    hn::StoreU(hn::DemoteTo(bytes, mixed<kShift>(d, levels, weights.luma, weights.luma_offset)), bytes,
               out + k);
  });
}

// U and V of two rows of n pixels in planes of red, green and blue. If n is odd, the last pair is one pixel.
void pairs_of_chroma(const uint8_t* upper, const uint8_t* lower, int64_t plane, const ChromaWeights& weights,
                     int64_t n, uint8_t* out) {
  const auto pair = [=](auto d, const auto* sums) {
    const auto u = mixed<kShift + 2>(d, sums, weights.first, weights.chroma_offset),
               v = mixed<kShift + 2>(d, sums, weights.second, weights.chroma_offset);
    return hn::Or(u, hn::ShiftLeft<8>(v));
  };
  for_lanes<int32_t>(n / 2, [=](auto d, auto, int64_t k) {
    hn::Vec<decltype(d)> sums[3];
    for (int c = 0; c < 3; ++c) {
      hn::Vec<decltype(d)> a, b, e, f;
      both_of(d, upper + c * plane + 2 * k, a, b);
      both_of(d, lower + c * plane + 2 * k, e, f);
      sums[c] = hn::Add(hn::Add(a, b), hn::Add(e, f));
    }
    const hn::Rebind<uint16_t, decltype(d)> words;
    hn::StoreU(hn::DemoteTo(words, pair(d, sums)), words, reinterpret_cast<uint16_t*>(out + 2 * k));
  });
  if (n % 2 == 0) return;
  const Lane<int32_t> d;
  hn::Vec<decltype(d)> sums[3];
  for (int c = 0; c < 3; ++c) sums[c] = hn::Set(d, 2 * (upper[c * plane + n - 1] + lower[c * plane + n - 1]));
  const auto last = hn::GetLane(pair(d, sums));
  out[n - 1] = static_cast<uint8_t>(last);
  out[n] = static_cast<uint8_t>(last >> 8);
}

}  // namespace

void subsampled_pixels(const uint8_t* luma, int64_t n, int64_t height, int64_t width, const uint8_t* chroma,
                       int64_t rows, int64_t values, const int32_t* weights, bool swapped, bool interleaved,
                       uint8_t* out) {
  const auto run = [&](auto order) {
    constexpr bool kSwapped = decltype(order)::value;
    to_rgb(
        {luma, n, height, width, rows, values / 2}, Factors(weights), interleaved, out,
        [=](const uint8_t* bright, int64_t row, int64_t first) {
          return Interleaved<kSwapped>{bright, chroma + row * values + first};
        },
        [=](int64_t row, int64_t column) {
          const uint8_t* const pair = chroma + row * values + 2 * column;
          return std::pair(pair[kSwapped], pair[!kSwapped]);
        });
  };
  if (swapped)
    run(std::true_type());
  else
    run(std::false_type());
}

void subsampled_planes(const uint8_t* luma, int64_t n, int64_t height, int64_t width, const uint8_t* u,
                       int64_t rows, int64_t columns, const uint8_t* v, const int32_t* weights,
                       bool interleaved, uint8_t* out) {
  to_rgb(
      {luma, n, height, width, rows, columns}, Factors(weights), interleaved, out,
      [=](const uint8_t* bright, int64_t row, int64_t first) {
        const int64_t start = row * columns + first / 2;
        return Split{bright, u + start, v + start};
      },
      [=](int64_t row, int64_t column) {
        return std::pair(u[row * columns + column], v[row * columns + column]);
      });
}

void packed_pixels(const uint8_t* x, int64_t n, int64_t height, int64_t values, const int32_t* weights,
                   bool luma_first, bool interleaved, uint8_t* out) {
  const Factors factors(weights);
  const int64_t width = values / 2;
#pragma omp parallel for
  for (int64_t i = 0; i < n * height; ++i) {
    uint8_t* const to = out + (interleaved ? 3 * i : 3 * (i / height) * height + i % height) * width;
    row_of_pixels(width, interleaved, to, height * width,
                  [&](int64_t first, int64_t count, uint8_t* made, int64_t plane) {
                    const uint8_t* const from = x + i * values + 2 * first;
                    if (luma_first)
                      run_of_pairs(Packed<true>{from}, factors, count / 2, made, plane);
                    else
                      run_of_pairs(Packed<false>{from}, factors, count / 2, made, plane);
                  });
  }
}

void nv12_pixels(const uint8_t* x, int64_t n, int64_t values, const int32_t* weights, int64_t height,
                 bool interleaved, uint8_t* out) {
  const ChromaWeights factors(weights);
  const int64_t plane = values / 3, width = plane / height, rows = (height + 1) / 2,
                columns = (width + 1) / 2, made = plane + 2 * rows * columns;
#pragma omp parallel for
  for (int64_t i = 0; i < n * rows; ++i) {
    const int64_t image = i / rows, row = i % rows;
    const uint8_t* const from = x + image * values;
    uint8_t* const luma = out + image * made;
    uint8_t* const chroma = luma + plane + 2 * row * columns;
    uint8_t parts[2][3 * kPart];
    for (int64_t first = 0; first < width; first += kPart) {
      const int64_t count = std::min(kPart, width - first);
      const uint8_t* pair[2];
      for (int64_t k = 0; k < 2; ++k) {
        const int64_t start = std::min(2 * row + k, height - 1) * width + first;
        pair[k] = from + start;
        if (interleaved) {
          split_run<uint8_t, 3>(from + 3 * start, count, kPart, parts[k]);
          pair[k] = parts[k];
        }
        luma_of(pair[k], interleaved ? kPart : plane, factors, count, luma + start);
      }
      pairs_of_chroma(pair[0], pair[1], interleaved ? kPart : plane, factors, count, chroma + first);
    }
  }
}

}  // namespace chiasm::kernels
