// Separable correlation of bytes in fixed point: taps are multiples of 1/256, so sums are exact.
//
// Down the columns, sums of bytes fit into 16 bits. Along the rows they would need 24: the high and the low
// byte of the first sum are weighted separately, so that both sums fit into 16 bits again.
#include "declared/separable_bytes.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

using Word = uint16_t;

// high[x] and low[x] are the bytes of the sum of rows[k][x] * taps[|k - radius|] for k = 0 .. 2 * radius.
void weigh_down(const uint8_t* const* rows, const Word* taps, int64_t radius, int64_t n, Word* high,
                Word* low) {
  for_lanes<Word, 2>(n, [=](auto d, auto vectors, int64_t x) {
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    const auto load = [=](int64_t k, int v) {
      return hn::PromoteTo(d, hn::LoadU(bytes, rows[k] + x + v * lanes));
    };
    hn::Vec<decltype(d)> sum[vectors];
    for (int v = 0; v < vectors; ++v) sum[v] = hn::Mul(load(radius, v), hn::Set(d, taps[0]));
    for (int64_t k = 1; k <= radius; ++k) {
      const auto tap = hn::Set(d, taps[k]);
      for (int v = 0; v < vectors; ++v)
        sum[v] = hn::Add(sum[v], hn::Mul(hn::Add(load(radius - k, v), load(radius + k, v)), tap));
    }
    for (int v = 0; v < vectors; ++v) {
      hn::StoreU(hn::ShiftRight<8>(sum[v]), d, high + x + v * lanes);
      hn::StoreU(hn::And(sum[v], hn::Set(d, Word{255})), d, low + x + v * lanes);
    }
  });
}

// out[x] is the sum of (256 * high + low)[x + k * step] * taps[|k|] divided by 2^16, rounded half up.
void weigh_along(const Word* high, const Word* low, const Word* taps, int64_t radius, int64_t step, int64_t n,
                 uint8_t* out) {
  for_lanes<Word, 2>(n, [=](auto d, auto vectors, int64_t x) {
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    hn::Vec<decltype(d)> upper[vectors], lower[vectors];
    const auto middle = hn::Set(d, taps[0]);
    for (int v = 0; v < vectors; ++v) {
      upper[v] = hn::Mul(hn::LoadU(d, high + x + v * lanes), middle);
      lower[v] = hn::Mul(hn::LoadU(d, low + x + v * lanes), middle);
    }
    for (int64_t k = 1; k <= radius; ++k) {
      const auto tap = hn::Set(d, taps[k]);
      const auto pair = [=](const Word* row, int v) {
        const Word* const at = row + x + v * lanes;
        return hn::Mul(hn::Add(hn::LoadU(d, at - k * step), hn::LoadU(d, at + k * step)), tap);
      };
      for (int v = 0; v < vectors; ++v) {
        upper[v] = hn::Add(upper[v], pair(high, v));
        lower[v] = hn::Add(lower[v], pair(low, v));
      }
    }
    for (int v = 0; v < vectors; ++v) {
      const auto sum = hn::Add(hn::Add(upper[v], hn::ShiftRight<8>(lower[v])), hn::Set(d, Word{128}));
      hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(hn::RebindToSigned<decltype(d)>(), hn::ShiftRight<8>(sum))),
                 bytes, out + x + v * lanes);
    }
  });
}

std::vector<Word> words(const int32_t* taps, int64_t count) {
  std::vector<Word> result(static_cast<size_t>(count));
  std::transform(taps, taps + count, result.begin(), [](int32_t tap) { return static_cast<Word>(tap); });
  return result;
}

}  // namespace

void separable_bytes(const uint8_t* x, int64_t n, int64_t height, int64_t width, const int32_t* taps_y,
                     int64_t ny, int64_t ky, const int32_t* taps_x, int64_t nx, int64_t kx, int64_t step,
                     Border border, uint8_t* out) {
  const Planes planes{n, height, width, step};
  const int64_t ry = ky - 1, rx = kx - 1, reach = rx * step;
  const std::vector<Word> all_y = words(taps_y, ny * ky), all_x = words(taps_x, nx * kx);
  std::vector<const uint8_t*> all_rows(static_cast<size_t>((2 * ry + 1) * omp_get_max_threads()));
  const std::vector<uint8_t> zeros(border == Border::kConstant ? static_cast<size_t>(width) : 0);
  const int64_t lead = whole_lines<Word>(reach);
  for_tiles<Word>(planes, ky + 2, 2, lead + reach, border,
                  [&](const Tile& tile, Word* scratch, int64_t length) {
                    const uint8_t* const image = x + tile.plane * height * width;
                    const Word* const down = all_y.data() + tile.plane * ny / n * ky;
                    const Word* const along = all_x.data() + tile.plane * nx / n * kx;
                    const uint8_t** const rows = all_rows.data() + (2 * ry + 1) * omp_get_thread_num();
                    const Span span(tile, width, reach, reach);
                    Word *const high = scratch + lead, *const low = high + length;
                    const int64_t start = span.first - tile.left;
                    for (int64_t y = tile.top; y < tile.bottom; ++y) {
                      for (int64_t i = 0; i <= 2 * ry; ++i) {
                        const int64_t row = inside(y + i - ry, height, border);
                        rows[i] = row < 0 ? zeros.data() : image + row * width + span.first;
                      }
                      weigh_down(rows, down, ry, span.count(), high + start, low + start);
                      for (Word* const values : {high, low})
                        extend(values, tile, width, reach, reach, border, Word{0}, step);
                      weigh_along(high, low, along, rx, step, tile.right - tile.left,
                                  tile_row(out + tile.plane * height * width, planes, tile, y));
                    }
                  });
}

}  // namespace chiasm::kernels
