// Bilateral filtering. Both pixels of a pair have the same weight: it is computed once, and kept for as many
// rows as the window reaches down.
#include "declared/bilateral.h"
#include "functions.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// Exponentials of numbers <= 0; NaN stays NaN. Weights below 1e-34 become 0: arithmetic with denormal numbers
// takes many times as long, and they are negligible beside the weight of the centre.
//
// For float, the function of S. Moshier's Cephes library (netlib.org/cephes) is inlined: calls of a vector
// library spill registers.
template <class D>
hn::Vec<D> exp_of(D d, hn::Vec<D> x) {
  const auto least = hn::Set(d, -78), inside = larger(least, x);
  if constexpr (std::is_same_v<hn::TFromD<D>, double>) {
    return hn::IfThenZeroElse(hn::Le(x, least), vector_exp(inside));
  } else {
    const auto n = hn::Round(hn::Mul(inside, hn::Set(d, 1.44269504088896341f)));
    const auto r =
        hn::NegMulAdd(n, hn::Set(d, -2.12194440e-4f), hn::NegMulAdd(n, hn::Set(d, 0.693359375f), inside));
    auto p = hn::Set(d, 1.9875691500e-4f);
    for (const float c :
         {1.3981999507e-3f, 8.3334519073e-3f, 4.1665795894e-2f, 1.6666665459e-1f, 5.0000001201e-1f})
      p = hn::MulAdd(p, r, hn::Set(d, c));
    const auto near = hn::Add(hn::MulAdd(p, hn::Mul(r, r), r), hn::Set(d, 1));
    // After adding 1.5 * 2^23, the last bits of a float are the integer. The shift keeps only the exponent's
    // bits.
    const Integers<D> integers;
    const auto power =
        hn::BitCast(d, hn::ShiftLeft<23>(hn::BitCast(integers, hn::Add(n, hn::Set(d, 12582912.0f + 127)))));
    return hn::IfThenZeroElse(hn::Le(x, least), hn::Mul(near, power));
  }
}

// The offset to a neighbour later in raster order, and its spatial weights.
template <class T>
struct Offset {
  int64_t dy, dx;
  T space_weight;
};

// weights[x] = space_weight times the weight of the distance of here[c][x] and there[c][x] over `depth`
// channels; whole vectors, also at the end.
template <class T, class RangeWeights>
void weigh_pairs(const T* const* here, const T* const* there, int64_t depth, int64_t n,
                 const RangeWeights& range_weights, T space_weight, bool squares, T* weights) {
  const Lanes<T> d;
  for (int64_t x = 0; x < n; x += kLanes<T>) {
    auto distance = hn::Zero(d);
    for (int64_t c = 0; c < depth; ++c) {
      const auto difference = hn::Sub(hn::LoadU(d, there[c] + x), hn::LoadU(d, here[c] + x));
      distance = hn::Add(distance, squares ? hn::Mul(difference, difference) : hn::Abs(difference));
    }
    hn::StoreU(hn::Mul(range_weights.weight(d, distance, squares), hn::Set(d, space_weight)), d, weights + x);
  }
}

// totals[x] = first + the sum of weights[k][x]; whole vectors, also at the end.
template <class T, int64_t vectors>
void add_weights(T first, const T* const* weights, int64_t count, int64_t x, T* totals) {
  const Lanes<T> d;
  hn::Vec<Lanes<T>> total[vectors];
  for (auto& t : total) t = hn::Set(d, first);
  for (int64_t k = 0; k < count; ++k)
    for (int64_t v = 0; v < vectors; ++v)
      total[v] = hn::Add(total[v], hn::LoadU(d, weights[k] + x + v * kLanes<T>));
  for (int64_t v = 0; v < vectors; ++v) hn::StoreU(total[v], d, totals + x + v * kLanes<T>);
}

// means[x] = (first * centre[x] + the sum of weights[k][x] * values[k][x]) / totals[x]; whole vectors, also
// at the end.
template <class RangeWeights, class T, int64_t vectors>
void weighted_means(T first, const T* centre, const T* const* weights, const T* const* values, int64_t count,
                    const T* totals, int64_t x, T* means) {
  const Lanes<T> d;
  const auto at = [=](const T* p, int64_t v) { return hn::LoadU(d, p + x + v * kLanes<T>); };
  hn::Vec<Lanes<T>> sum[vectors];
  for (int64_t v = 0; v < vectors; ++v) sum[v] = hn::Mul(at(centre, v), hn::Set(d, first));
  for (int64_t k = 0; k < count; ++k)
    for (int64_t v = 0; v < vectors; ++v)
      sum[v] = RangeWeights::sum(sum[v], at(values[k], v), at(weights[k], v));
  for (int64_t v = 0; v < vectors; ++v)
    hn::StoreU(RangeWeights::mean(d, sum[v], at(totals, v)), d, means + x + v * kLanes<T>);
}

// Calls four(x) for each block of four vectors, whose sums do not depend on each other, and one(x) for each
// remaining vector.
template <class T, class Four, class One>
inline void for_blocks(int64_t n, const Four& four, const One& one) {
  constexpr int64_t lanes = kLanes<T>;
  int64_t x = 0;
  for (; x + 4 * lanes <= n; x += 4 * lanes) four(x);
  for (; x < n; x += lanes) one(x);
}

// exp(coefficient * distance^2), and quotients. `most` is the weight of a pixel's own colour.
template <class T>
struct GaussianOfRange {
  T coefficient;

  T most() const { return 1; }

  template <class D>
  HWY_INLINE hn::Vec<D> weight(D d, hn::Vec<D> distance, bool squares) const {
    const auto squared = squares ? distance : hn::Mul(distance, distance);
    return exp_of(d, hn::Mul(squared, hn::Set(d, coefficient)));
  }

  template <class V>
  static HWY_INLINE V sum(V sum, V value, V weight) {
    return hn::Add(sum, hn::Mul(value, weight));
  }

  template <class D>
  static HWY_INLINE hn::Vec<D> mean(D, hn::Vec<D> sum, hn::Vec<D> total) {
    return hn::Div(sum, total);
  }
};

// The entries of a table at integer distances, and quotients rounded half up.
struct TableOfRange {
  const double* entries;
  double last;  // limits distances, which are arbitrary beyond a row's end

  double most() const { return entries[0]; }

  template <class D>
  HWY_INLINE hn::Vec<D> weight(D d, hn::Vec<D> distance, bool) const {
    const hn::RebindToSigned<D> whole;
    const auto index = truncated(d, smaller(distance, hn::Set(d, last)));
    return hn::GatherIndex(d, entries, hn::PromoteTo(whole, index));
  }

  template <class V>
  static HWY_INLINE V sum(V sum, V value, V weight) {
    return hn::MulAdd(value, weight, sum);
  }

  template <class D>
  static HWY_INLINE hn::Vec<D> mean(D d, hn::Vec<D> sum, hn::Vec<D> total) {
    const auto twice = hn::Add(total, total);
    return hn::Floor(hn::Div(hn::Add(hn::Add(sum, sum), total), larger(twice, hn::Set(d, 1.0))));
  }
};

// Copies pixels to numbers, and numbers to pixels.
template <class T>
void copy_pixels(const T* x, int64_t n, T* out) {
  std::copy_n(x, n, out);
}

void copy_pixels(const uint8_t* x, int64_t n, double* out) {
  for_lanes<double>(n, [=](auto d, auto, int64_t k) {
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    const auto whole = hn::PromoteTo(Integers<decltype(d)>(), hn::LoadU(bytes, x + k));
    hn::StoreU(hn::PromoteTo(d, whole), d, out + k);
  });
}

void copy_pixels(const double* x, int64_t n, uint8_t* out) {
  for_lanes<double>(n, [=](auto d, auto, int64_t k) {
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    hn::StoreU(hn::DemoteTo(bytes, truncated(d, hn::LoadU(d, x + k))), bytes, out + k);
  });
}

// range_weights_of(image) returns the function from distances to weights for an image.
template <class T, class Pixel, class RangeWeightsOf>
void bilateral_means(const Pixel* x, Images images, const Pixel* guide, int64_t guides_given, int64_t depth,
                     const T* space_weights, int64_t windows, int64_t ky, int64_t kx,
                     const RangeWeightsOf& range_weights_of, Border border, bool squares, Pixel* out) {
  using RangeWeights = decltype(range_weights_of(0));
  const int64_t channels = images.channels, height = images.height, width = images.width,
                plane = height * width, rx = kx / 2, ry = ky / 2;
  const bool shared_guide = guides_given == 1;
  // A guide that is a view of the first planes, or of the first image, has the same address as the image.
  const bool own_guide = guide != x || depth != channels || (shared_guide && images.count > 1);
  const int64_t sources = channels + (own_guide ? depth : 0), guides = own_guide ? channels : 0,
                count = ky * kx / 2;
  // Scratch holds a ring of ky padded rows for each source, a ring of ry + 1 rows of weights for each offset,
  // the totals and the means.
  const int64_t image_rows = sources * ky, rows = image_rows + count * (ry + 1) + 2;
  const int64_t pointer_count = 2 * depth + 4 * count;
  std::vector<const T*> all_pointers(static_cast<size_t>(pointer_count * omp_get_max_threads()));
  for_tiles<T>(
      {images.count, height, width}, rows, rows, 2 * kx, border,
      [&](const Tile& tile, T* scratch, int64_t length) {
        const int64_t columns = tile.right - tile.left;
        const Span span(tile, width, rx, rx);
        const T* const window = space_weights + (windows == 1 ? 0 : tile.plane * ky * kx);
        const RangeWeights range_weights = range_weights_of(tile.plane);
        const auto source_row = [&](int64_t c, int64_t y) {
          return scratch + (c * ky + (y + 2 * ky) % ky) * length + rx;
        };
        const auto weight_row = [&](int64_t k, int64_t y) {
          return scratch + (image_rows + k * (ry + 1) + (y + 2 * ky * (ry + 1)) % (ry + 1)) * length + rx;
        };
        T *const totals = scratch + (rows - 2) * length, *const means = totals + length;
        const auto offset = [&](int64_t k) {  // offsets after the centre, in the window's order
          const int64_t i = count + 1 + k;
          return Offset<T>{i / kx - ry, i % kx - rx, window[i]};
        };
        const T** const here = all_pointers.data() + pointer_count * omp_get_thread_num();
        const T **const there = here + depth, **const weights = there + depth,
                        **const values = weights + 2 * count;
        const auto fetch = [&](int64_t y) {
          const int64_t row = inside(y, height, border);
          for (int64_t c = 0; c < sources; ++c) {
            T* const p = source_row(c, y);
            if (row < 0) {
              std::fill_n(p - rx, columns + 2 * rx, T(0));
              continue;
            }
            const Pixel* const image =
                c < channels ? x + (tile.plane * channels + c) * plane
                             : guide + ((shared_guide ? 0 : tile.plane) * depth + c - channels) * plane;
            copy_pixels(image + row * width + span.first, span.count(), p + span.first - tile.left);
            extend(p, tile, width, rx, rx, border, T(0));
          }
        };
        const auto weigh = [&](int64_t y) {  // the weights of row y with the rows below it
          for (int64_t k = 0; k < count; ++k) {
            const auto [dy, dx, near] = offset(k);
            // Also left or right of the tile: pixels of the tile need their weights with earlier pixels
            // there.
            const int64_t start = std::min<int64_t>(-dx, 0), end = columns + std::max<int64_t>(-dx, 0);
            for (int64_t c = 0; c < depth; ++c) {
              here[c] = source_row(guides + c, y) + start;
              there[c] = source_row(guides + c, y + dy) + start + dx;
            }
            weigh_pairs(here, there, depth, end - start, range_weights, near, squares,
                        weight_row(k, y) + start);
          }
        };
        for (int64_t y = tile.top - ry; y < tile.top + ry; ++y) fetch(y);
        for (int64_t y = tile.top - ry; y < tile.bottom; ++y) {
          // The weights of the first rows need only rows that have been fetched.
          if (y >= tile.top) fetch(y + ry);
          weigh(y);
          if (y < tile.top) continue;
          for (int64_t k = 0; k < count; ++k) {
            const auto [dy, dx, near] = offset(k);
            weights[2 * k] = weight_row(k, y);
            weights[2 * k + 1] = weight_row(k, y - dy) - dx;
          }
          const T self = window[count] * range_weights.most();
          for_blocks<T>(
              columns, [=](int64_t k) { add_weights<T, 4>(self, weights, 2 * count, k, totals); },
              [=](int64_t k) { add_weights<T, 1>(self, weights, 2 * count, k, totals); });
          for (int64_t c = 0; c < channels; ++c) {
            for (int64_t k = 0; k < count; ++k) {
              const auto [dy, dx, near] = offset(k);
              values[2 * k] = source_row(c, y + dy) + dx;
              values[2 * k + 1] = source_row(c, y - dy) - dx;
            }
            const T* const centre = source_row(c, y);
            for_blocks<T>(
                columns,
                [=](int64_t k) {
                  weighted_means<RangeWeights, T, 4>(self, centre, weights, values, 2 * count, totals, k,
                                                     means);
                },
                [=](int64_t k) {
                  weighted_means<RangeWeights, T, 1>(self, centre, weights, values, 2 * count, totals, k,
                                                     means);
                });
            copy_pixels(means, columns, out + (tile.plane * channels + c) * plane + y * width + tile.left);
          }
        }
      });
}

}  // namespace

template <class T>
void bilateral(const T* x, Images images, const T* guide, int64_t guides_given, int64_t depth,
               const T* space_weights, int64_t windows, int64_t ky, int64_t kx, const T* range_coefficient,
               int64_t coefficients, Border border, bool euclidean, T* out) {
  const auto range_weights_of = [=](int64_t image) {
    return GaussianOfRange<T>{range_coefficient[coefficients == 1 ? 0 : image]};
  };
  bilateral_means<T>(x, images, guide, guides_given, depth, space_weights, windows, ky, kx, range_weights_of,
                     border, euclidean, out);
}

void bilateral_bytes(const uint8_t* x, Images images, const uint8_t* guide, int64_t guides_given,
                     int64_t depth, const double* space_weights, int64_t windows, int64_t ky, int64_t kx,
                     const double* range_weights, int64_t tables, int64_t entries, Border border,
                     bool squares, uint8_t* out) {
  const auto range_weights_of = [=](int64_t image) {
    return TableOfRange{range_weights + (tables == 1 ? 0 : image * entries),
                        static_cast<double>(entries - 1)};
  };
  bilateral_means<double>(x, images, guide, guides_given, depth, space_weights, windows, ky, kx,
                          range_weights_of, border, squares, out);
}

CHIASM_INSTANTIATE(bilateral)

}  // namespace chiasm::kernels
