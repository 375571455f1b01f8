// Correlation of bytes with windows of integers: float32 represents the sums exactly, in any order of
// addition.
#include "declared/correlate_bytes.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// out[x] = scale times the sum of sources[k][x] * taps[k], rounded half to even, saturated.
void weigh(const float* const* sources, const float* taps, int64_t count, float scale, int64_t n,
           uint8_t* out) {
  for_lanes<float, 4>(n, [=](auto d, auto vectors, int64_t x) {
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    hn::Vec<decltype(d)> sum[vectors];
    for (int v = 0; v < vectors; ++v) sum[v] = hn::Zero(d);
    for (int64_t k = 0; k < count; ++k) {
      const auto tap = hn::Set(d, taps[k]);
      for (int v = 0; v < vectors; ++v)
        sum[v] = hn::MulAdd(hn::LoadU(d, sources[k] + x + v * lanes), tap, sum[v]);
    }
    for (int v = 0; v < vectors; ++v) {
      const auto value = hn::Mul(sum[v], hn::Set(d, scale));
      const auto level = smaller(larger(value, hn::Set(d, -1.0f)), hn::Set(d, 256.0f));
      hn::StoreU(hn::DemoteTo(bytes, hn::NearestInt(level)), bytes, out + x + v * lanes);
    }
  });
}

}  // namespace

void correlate_bytes(const uint8_t* x, int64_t n, int64_t height, int64_t width, const float* taps,
                     int64_t windows, int64_t kh, int64_t kw, const float* scale, int64_t step, Border border,
                     uint8_t* out) {
  using Rows = PaddedRows<float, uint8_t>;
  const Planes planes{n, height, width, step};
  const int64_t count = kh * kw, row = (kh - 1) / 2, column = (kw - 1) / 2;
  std::vector<const float*> all_sources(static_cast<size_t>(count * omp_get_max_threads()));
  std::vector<float> all_taps(all_sources.size());
  for_tiles<float>(planes, kh + 2, kh, Rows::ends(planes, kw, column), border,
                   [&](const Tile& tile, float* ring, int64_t length) {
                     const int64_t window = tile.plane * windows / n, plane = tile.plane * height * width;
                     const float** const sources = all_sources.data() + count * omp_get_thread_num();
                     float* const used = all_taps.data() + count * omp_get_thread_num();
                     const Rows rows(x + plane, planes, tile, border, 0, kh, kw, row, column, ring, length);
                     for (int64_t y = tile.top; y < tile.bottom; ++y) {
                       rows.advance(y, x + plane);
                       int64_t terms = 0;
                       for (int64_t k = 0; k < count; ++k) {
                         used[terms] = taps[window * count + k];
                         sources[terms] = rows.at(y, k / kw, k % kw);
                         terms += used[terms] != 0;
                       }
                       weigh(sources, used, terms, scale[window], tile.right - tile.left,
                             tile_row(out + plane, planes, tile, y));
                     }
                   });
}

}  // namespace chiasm::kernels
