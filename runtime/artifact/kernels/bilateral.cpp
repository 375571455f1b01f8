// Bilateral filtering. The weight of two pixels is the same for both: it is computed once, for the later of the two in reading order, and
// kept for as many rows as the window reaches down.
#include "rows.h"

extern "C" __m256d _ZGVdN4v_exp(__m256d);  // glibc's libmvec

namespace chiasm::kernels {
namespace {

// Exponentials of numbers that are not positive; NaN stays. Weights below 1e-34 are 0: arithmetic with numbers that have no exponent of their own
// takes many times as long, and next to a pixel's weight for itself they are nothing.
//
// For float the function of S. Moshier's Cephes library (netlib.org/cephes), within the loop: a vector library's calls spill registers.
__m256 exp_of(__m256 x) {
  const __m256 least = _mm256_set1_ps(-78.0f), inside = _mm256_max_ps(least, x);
  const __m256 n = _mm256_round_ps(inside * 1.44269504088896341f, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
  const __m256 r = _mm256_fnmadd_ps(n, _mm256_set1_ps(-2.12194440e-4f), _mm256_fnmadd_ps(n, _mm256_set1_ps(0.693359375f), inside));
  __m256 p = _mm256_set1_ps(1.9875691500e-4f);
  for (const float c : {1.3981999507e-3f, 8.3334519073e-3f, 4.1665795894e-2f, 1.6666665459e-1f, 5.0000001201e-1f}) p = _mm256_fmadd_ps(p, r, _mm256_set1_ps(c));
  const __m256 near = _mm256_fmadd_ps(p, r * r, r) + 1.0f;
  const __m256i exponent = _mm256_slli_epi32(_mm256_add_epi32(_mm256_cvtps_epi32(n), _mm256_set1_epi32(127)), 23);
  return _mm256_andnot_ps((__m256)(x <= least), near * _mm256_castsi256_ps(exponent));
}

__m256d exp_of(__m256d x) {
  const __m256d least = _mm256_set1_pd(-78.0);
  return _mm256_andnot_pd((__m256d)(x <= least), _ZGVdN4v_exp(_mm256_max_pd(least, x)));
}

// The way to a pixel's neighbour that comes later, and where the weights for it lie.
template <class T>
struct Offset {
  int64_t dy, dx;
  T nearness;
};

// weights[x] = exp(falloff * distance^2) * nearness, of here[c][x] and there[c][x] in `depth` channels; up to a whole vector at the end.
template <class T>
void weigh_pairs(const T* const* here, const T* const* there, int64_t depth, int64_t n, T falloff, T nearness, bool squares, T* weights) {
  using V = Vector<T>;
  for (int64_t x = 0; x < n; x += V::kLanes) {
    auto distance = V::all(0);
    for (int64_t c = 0; c < depth; ++c) {
      const auto difference = V::load(there[c] + x) - V::load(here[c] + x);
      distance += squares ? difference * difference : V::max(difference, -difference);
    }
    if (!squares) distance *= distance;
    V::store(weights + x, exp_of(distance * V::all(falloff)) * V::all(nearness));
  }
}

// totals[x] = first + the sum of weights[k][x]; up to a whole vector at the end.
template <class T, int64_t vectors>
void add_weights(T first, const T* const* weights, int64_t count, int64_t x, T* totals) {
  using V = Vector<T>;
  typename V::Type total[vectors];
  for (auto& t : total) t = V::all(first);
  for (int64_t k = 0; k < count; ++k)
    for (int64_t v = 0; v < vectors; ++v) total[v] += V::load(weights[k] + x + v * V::kLanes);
  for (int64_t v = 0; v < vectors; ++v) V::store(totals + x + v * V::kLanes, total[v]);
}

// means[x] = (first * centre[x] + the sum of weights[k][x] * values[k][x]) / totals[x]; up to a whole vector at the end.
template <class T, int64_t vectors>
void weighted_means(T first, const T* centre, const T* const* weights, const T* const* values, int64_t count, const T* totals, int64_t x, T* means) {
  using V = Vector<T>;
  typename V::Type sum[vectors];
  for (int64_t v = 0; v < vectors; ++v) sum[v] = V::load(centre + x + v * V::kLanes) * V::all(first);
  for (int64_t k = 0; k < count; ++k)
    for (int64_t v = 0; v < vectors; ++v) sum[v] += V::load(values[k] + x + v * V::kLanes) * V::load(weights[k] + x + v * V::kLanes);
  for (int64_t v = 0; v < vectors; ++v) V::store(means + x + v * V::kLanes, sum[v] / V::load(totals + x + v * V::kLanes));
}

// Calls four(x) for as many blocks of four vectors as n values fill, whose sums do not wait for each other, and one(x) for the rest.
template <class T, class Four, class One>
inline void for_blocks(int64_t n, const Four& four, const One& one) {
  constexpr int64_t lanes = Vector<T>::kLanes;
  int64_t x = 0;
  for (; x + 4 * lanes <= n; x += 4 * lanes) four(x);
  for (; x < n; x += lanes) one(x);
}

}  // namespace

template <class T>
void bilateral(const T* x, int64_t channels, const T* guide, int64_t depth, bool shared_guide, Planes images, const T* nearness, bool shared_nearness,
               int64_t ky, int64_t kx, const T* falloff, bool shared_falloff, Border border, bool squares, T* out) {
  const int64_t height = images.height, width = images.width, plane = height * width, rx = kx / 2, ry = ky / 2;
  // A view of the image's first planes, or of its first image, begins where the image does.
  const bool own_guide = guide != x || depth != channels || (shared_guide && images.count > 1);
  const int64_t sources = channels + (own_guide ? depth : 0), guides = own_guide ? channels : 0, count = ky * kx / 2;
  // In scratch: a ring of ky padded rows of each source, one of ry + 1 rows of weights for each offset, the totals and the means.
  const int64_t image_rows = sources * ky, rows = image_rows + count * (ry + 1) + 2;
  const int64_t pointer_count = 2 * depth + 4 * count;
  std::vector<const T*> all_pointers(static_cast<size_t>(pointer_count * omp_get_max_threads()));
  for_tiles<T>(images, rows, rows, 2 * kx, border, [&](const Tile& tile, T* scratch, int64_t length) {
    const int64_t columns = tile.right - tile.left;
    const Span span(tile, width, rx, rx);
    const T* const window = nearness + (shared_nearness ? 0 : tile.plane * ky * kx);
    const T fall = falloff[shared_falloff ? 0 : tile.plane];
    const auto source_row = [&](int64_t c, int64_t y) { return scratch + (c * ky + (y + 2 * ky) % ky) * length + rx; };
    const auto weight_row = [&](int64_t k, int64_t y) { return scratch + (image_rows + k * (ry + 1) + (y + 2 * ky * (ry + 1)) % (ry + 1)) * length + rx; };
    T *const totals = scratch + (rows - 2) * length, *const means = totals + length;
    const auto offset = [&](int64_t k) {  // in the window's order, behind its centre
      const int64_t i = count + 1 + k;
      return Offset<T>{i / kx - ry, i % kx - rx, window[i]};
    };
    const T** const here = all_pointers.data() + pointer_count * omp_get_thread_num();
    const T **const there = here + depth, **const weights = there + depth, **const values = weights + 2 * count;
    const auto fetch = [&](int64_t y) {
      const int64_t row = inside(y, height, border);
      for (int64_t c = 0; c < sources; ++c) {
        T* const p = source_row(c, y);
        if (row < 0) {
          std::fill_n(p - rx, columns + 2 * rx, T(0));
          continue;
        }
        const T* const image = c < channels ? x + (tile.plane * channels + c) * plane : guide + ((shared_guide ? 0 : tile.plane) * depth + c - channels) * plane;
        std::copy_n(image + row * width + span.first, span.count(), p + span.first - tile.left);
        extend(p, tile, width, rx, rx, border, T(0));
      }
    };
    const auto weigh = [&](int64_t y) {  // row y with those below it
      for (int64_t k = 0; k < count; ++k) {
        const auto [dy, dx, near] = offset(k);
        // From where a pixel of the tile has its weight with the one before it, to the tile's end or beyond.
        const int64_t start = std::min<int64_t>(-dx, 0), end = columns + std::max<int64_t>(-dx, 0);
        for (int64_t c = 0; c < depth; ++c) {
          here[c] = source_row(guides + c, y) + start;
          there[c] = source_row(guides + c, y + dy) + start + dx;
        }
        weigh_pairs(here, there, depth, end - start, fall, near, squares, weight_row(k, y) + start);
      }
    };
    for (int64_t y = tile.top - ry; y < tile.top + ry; ++y) fetch(y);
    for (int64_t y = tile.top - ry; y < tile.bottom; ++y) {
      // The first rows' weights are for the rows below them, all of which are there.
      if (y >= tile.top) fetch(y + ry);
      weigh(y);
      if (y < tile.top) continue;
      for (int64_t k = 0; k < count; ++k) {
        const auto [dy, dx, near] = offset(k);
        weights[2 * k] = weight_row(k, y);
        weights[2 * k + 1] = weight_row(k, y - dy) - dx;
      }
      const T self = window[count];
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
            columns, [=](int64_t k) { weighted_means<T, 4>(self, centre, weights, values, 2 * count, totals, k, means); },
            [=](int64_t k) { weighted_means<T, 1>(self, centre, weights, values, 2 * count, totals, k, means); });
        std::copy_n(means, columns, out + (tile.plane * channels + c) * plane + y * width + tile.left);
      }
    }
  });
}

template void bilateral(const float*, int64_t, const float*, int64_t, bool, Planes, const float*, bool, int64_t, int64_t, const float*, bool, Border, bool,
                        float*);
template void bilateral(const double*, int64_t, const double*, int64_t, bool, Planes, const double*, bool, int64_t, int64_t, const double*, bool, Border,
                        bool, double*);

}  // namespace chiasm::kernels
