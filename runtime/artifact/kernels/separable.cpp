// Correlation. With a separable kernel, each row is first summed down the columns into a buffer that stays in
// cache, and then along the row.
#include "declared/separable.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// The function of a sum that is stored: the sum itself, or scale * sum + centre * x[k].
struct Itself {
  template <class D>
  hn::Vec<D> operator()(D, hn::Vec<D> sum, int64_t) const {
    return sum;
  }
};

template <class T>
struct Combined {
  const T* x;
  T scale, centre;
  template <class D>
  hn::Vec<D> operator()(D d, hn::Vec<D> sum, int64_t k) const {
    return hn::Add(hn::Mul(sum, hn::Set(d, scale)), hn::Mul(hn::LoadU(d, x + k), hn::Set(d, centre)));
  }
};

// out[x] = made(sum of sources[k][x] * taps[k]). Four vectors at a time, whose additions do not depend on
// each other.
template <class T, class Made>
void weigh(const T* const* sources, const T* taps, int64_t count, Made made, T* out, int64_t n,
           const T* next) {
  for_lanes_fetching<T, 4, true>(n, next, [=](auto d, auto vectors, int64_t x) {
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    auto tap = hn::Set(d, taps[0]);
    hn::Vec<decltype(d)> sum[vectors];
    for (int v = 0; v < vectors; ++v) sum[v] = hn::Mul(hn::LoadU(d, sources[0] + x + v * lanes), tap);
    for (int64_t k = 1; k < count; ++k) {
      tap = hn::Set(d, taps[k]);
      const T* const p = sources[k] + x;
      for (int v = 0; v < vectors; ++v) sum[v] = hn::Add(sum[v], hn::Mul(hn::LoadU(d, p + v * lanes), tap));
    }
    for (int v = 0; v < vectors; ++v) hn::StoreU(made(d, sum[v], x + v * lanes), d, out + x + v * lanes);
  });
}

// The same with 2 * kPairs + 1 symmetric taps: one product for each pair, as in stencil.weigh_shifts.
template <class T, class Made, int kPairs>
void weigh_pairs(const T* const* sources, const T* taps, int64_t, Made made, T* out, int64_t n,
                 const T* next) {
  const T* from[2 * kPairs + 1];
  T tap[kPairs + 1];
  for (int k = 0; k <= 2 * kPairs; ++k) from[k] = sources[k];
  for (int k = 0; k <= kPairs; ++k) tap[k] = taps[k];
  for_lanes_fetching<T, 4, true>(n, next, [=](auto d, auto vectors, int64_t x) {
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    hn::Vec<decltype(d)> sum[vectors];
    for (int v = 0; v < vectors; ++v)
      sum[v] = hn::Mul(hn::LoadU(d, from[kPairs] + x + v * lanes), hn::Set(d, tap[kPairs]));
#pragma GCC unroll 8
    for (int k = 0; k < kPairs; ++k) {
      const T *const first = from[k] + x, *const last = from[2 * kPairs - k] + x;
      for (int v = 0; v < vectors; ++v)
        sum[v] =
            hn::Add(sum[v], hn::Mul(hn::Add(hn::LoadU(d, first + v * lanes), hn::LoadU(d, last + v * lanes)),
                                    hn::Set(d, tap[k])));
    }
    for (int v = 0; v < vectors; ++v) hn::StoreU(made(d, sum[v], x + v * lanes), d, out + x + v * lanes);
  });
}

template <class T, class Made>
using Weigh = void (*)(const T* const* sources, const T* taps, int64_t count, Made made, T* out, int64_t n,
                       const T* next);

template <class T, class Made>
Weigh<T, Made> weigh_by(const T* taps, int64_t count) {
  for (int64_t k = 0; k < count / 2; ++k)
    if (taps[k] != taps[count - 1 - k]) return weigh<T, Made>;
  switch (count) {
    case 3: return weigh_pairs<T, Made, 1>;
    case 5: return weigh_pairs<T, Made, 2>;
    case 7: return weigh_pairs<T, Made, 3>;
    default: return weigh<T, Made>;
  }
}

}  // namespace

template <class T>
void separable(const T* x, Images images, const T* taps_y, int64_t ny, int64_t ky, const T* taps_x,
               int64_t nx, int64_t kx, Border border, T scale, T centre, T* out) {
  const Planes planes = images.planes();
  const int64_t height = planes.height, width = planes.width, ry = ky / 2, rx = kx / 2;
  std::vector<const T*> all_sources(static_cast<size_t>((ky + kx) * omp_get_max_threads()));
  const std::vector<T> zeros(border == Border::kConstant ? static_cast<size_t>(width) : 0);
  const int64_t lead = whole_lines<T>(rx);
  for_tiles<T>(planes, ky + 2, 1, lead + rx, border, [&](const Tile& tile, T* scratch, int64_t) {
    const T* const image = x + tile.plane * height * width;
    const T* const weights_y = taps_y + (ny > 1 ? tile.plane / images.channels * ky : 0);
    const T* const weights_x = taps_x + (nx > 1 ? tile.plane / images.channels * kx : 0);
    const auto down = weigh_by<T, Itself>(weights_y, ky), across = weigh_by<T, Itself>(weights_x, kx);
    const auto across_and_combine = weigh_by<T, Combined<T>>(weights_x, kx);
    const T** const rows = all_sources.data() + (ky + kx) * omp_get_thread_num();
    const T** const shifts = rows + ky;
    const Span span(tile, width, rx, rx);
    T* const buffer = scratch + lead;
    for (int64_t j = 0; j < kx; ++j) shifts[j] = buffer + j - rx;
    for (int64_t y = tile.top; y < tile.bottom; ++y) {
      for (int64_t i = 0; i < ky; ++i) {
        const int64_t row = inside(y + i - ry, height, border);
        rows[i] = row < 0 ? zeros.data() : image + row * width + span.first;
      }
      const int64_t start = (tile.plane * height + y) * width + tile.left, columns = tile.right - tile.left;
      const T* const next = tile_row(image, planes, tile, y + ry + 1);
      down(rows, weights_y, ky, {}, buffer + span.first - tile.left, span.count(), out + start);
      extend(buffer, tile, width, rx, rx, border, T(0));
      if (scale == 1 && centre == 0)
        across(shifts, weights_x, kx, {}, out + start, columns, next);
      else
        across_and_combine(shifts, weights_x, kx, {x + start, scale, centre}, out + start, columns, next);
    }
  });
}

template <class T>
void correlate2d(const T* x, Images images, const T* windows, int64_t n, int64_t kh, int64_t kw,
                 Border border, T* out) {
  const Planes planes = images.planes();
  const int64_t count = kh * kw;
  std::vector<const T*> all_sources(static_cast<size_t>(count * omp_get_max_threads()));
  const int64_t ends = PaddedRows<T>::ends(planes, kw, (kw - 1) / 2);
  for_tiles<T>(planes, kh + 2, kh, ends, border, [&](const Tile& tile, T* ring, int64_t length) {
    const int64_t plane = tile.plane * planes.height * planes.width;
    const T* const taps = windows + (n > 1 ? tile.plane / images.channels * count : 0);
    const T** const sources = all_sources.data() + count * omp_get_thread_num();
    const PaddedRows<T> rows(x + plane, planes, tile, border, T(0), kh, kw, (kh - 1) / 2, (kw - 1) / 2, ring,
                             length);
    for (int64_t y = tile.top; y < tile.bottom; ++y) {
      T* const target = tile_row(out + plane, planes, tile, y);
      const T* const next = rows.advance(y, target);
      for (int64_t i = 0; i < kh; ++i) {
        const T* const row = rows.at(y, i, 0);
        for (int64_t j = 0; j < kw; ++j) sources[i * kw + j] = row + j;
      }
      weigh(sources, taps, count, Itself(), target, tile.right - tile.left, next);
    }
  });
}

// The sum of a voxel's window has the order of the definition: by planes, rows, columns.
template <class T>
void correlate3d(const T* x, int64_t b, int64_t c, int64_t d, int64_t h, int64_t w, const T* windows,
                 int64_t n, int64_t kz, int64_t ky, int64_t kx, Border border, T* out) {
  const Planes planes{b * c * d, h, w};
  const int64_t count = kz * ky * kx, threads = omp_get_max_threads();
  const int64_t ends = PaddedRows<T>::ends(planes, kx, (kx - 1) / 2);
  std::vector<const T*> all_sources(static_cast<size_t>(count * threads));
  std::vector<std::vector<PaddedRows<T>>> all_rows(static_cast<size_t>(threads));
  for (auto& rows : all_rows) rows.reserve(static_cast<size_t>(kz));
  const std::vector<T> zeros(border == Border::kConstant ? static_cast<size_t>(padded_length<T>(w, 0)) : 0);
  for_tiles<T>(planes, kz * (ky + 1) + 1, kz * ky, ends, border,
               [&](const Tile& tile, T* rings, int64_t length) {
                 const int64_t volume = tile.plane / d, depth = tile.plane % d;
                 const T* const taps = windows + (n > 1 ? volume / c * count : 0);
                 const T** const sources = all_sources.data() + count * omp_get_thread_num();
                 // The rows of each plane of the window that is not beyond the volume.
                 std::vector<PaddedRows<T>>& rows = all_rows[static_cast<size_t>(omp_get_thread_num())];
                 rows.clear();
                 const auto plane = [&](int64_t k) { return inside(depth + k - (kz - 1) / 2, d, border); };
                 for (int64_t k = 0; k < kz; ++k)
                   if (plane(k) >= 0)
                     rows.emplace_back(x + (volume * d + plane(k)) * h * w, planes, tile, border, T(0), ky,
                                       kx, (ky - 1) / 2, (kx - 1) / 2, rings + k * ky * length, length);
                 for (int64_t y = tile.top; y < tile.bottom; ++y) {
                   T* const target = tile_row(out + tile.plane * h * w, planes, tile, y);
                   const T* next = target;
                   for (const PaddedRows<T>& of_plane : rows) next = of_plane.advance(y, target);
                   auto of_plane = rows.begin();
                   const T** source = sources;
                   for (int64_t k = 0; k < kz; ++k) {
                     const bool is_inside = plane(k) >= 0;
                     for (int64_t i = 0; i < ky; ++i) {
                       const T* const row = is_inside ? of_plane->at(y, i, 0) : zeros.data();
                       for (int64_t j = 0; j < kx; ++j) *source++ = is_inside ? row + j : row;
                     }
                     of_plane += is_inside;
                   }
                   weigh(sources, taps, count, Itself(), target, tile.right - tile.left, next);
                 }
               });
}

CHIASM_INSTANTIATE(separable)
CHIASM_INSTANTIATE(correlate2d)
CHIASM_INSTANTIATE(correlate3d)

}  // namespace chiasm::kernels
