// Thinning: removes a shape's border pixels until lines are left.
#include <array>
#include <bit>

#include "declared/thinning.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// Whether a pixel is removed, in the first or second half of an iteration. Bit n of the index is set if the
// n-th of the eight neighbours is set, clockwise from the north.
using Table = std::array<bool, 256>;

// T. Y. Zhang, C. Y. Suen, A fast parallel algorithm for thinning digital patterns, CACM 27(3), 1984.
bool zhang_suen(unsigned ring, bool first) {
  const auto at = [=](unsigned n) { return ring >> n % 8 & 1; };
  unsigned rises = 0;
  for (unsigned n = 0; n < 8; ++n) rises += !at(n) && at(n + 1);
  const unsigned north = at(0), east = at(2), south = at(4), west = at(6);
  const bool inner = first ? east && south && (north || west) : north && west && (east || south);
  return std::popcount(ring) >= 2 && std::popcount(ring) <= 6 && rises == 1 && !inner;
}

// Z. Guo, R. W. Hall, Parallel thinning with two-subiteration algorithms, CACM 32(3), 1989, whose neighbours
// run counter-clockwise from the east.
bool guo_hall(unsigned ring, bool first) {
  const auto at = [=](unsigned n) { return ring >> (10 - n % 8) % 8 & 1; };
  unsigned parts = 0, pairs = 0, other_pairs = 0;
  for (unsigned n = 0; n < 8; n += 2) {
    parts += !at(n) && (at(n + 1) || at(n + 2));
    pairs += at(n) || at(n + 1);
    other_pairs += at(n + 1) || at(n + 2);
  }
  const unsigned fewest = std::min(pairs, other_pairs), a = first ? 0 : 4;
  const bool inner = at(a) && (at(a + 1) || at(a + 2) || !at(a + 7));
  return parts == 1 && (fewest == 2 || fewest == 3) && !inner;
}

// A plane with a margin of one pixel, and each pixel's neighbours as bits. A pixel is checked again only
// after one of its neighbours was removed.
struct Peeling {
  const Table* goes;  // for both halves of an iteration
  int64_t height, width, stride;
  uint8_t *set, *ring, *waiting;
  int32_t* pending[2];  // for each half, the pixels whose bit of `waiting` is set
  int32_t* gone;
  int64_t count[2];

  void wait(int64_t i, int half) {
    if (waiting[i] & (1 << half)) return;
    waiting[i] = static_cast<uint8_t>(waiting[i] | (1 << half));
    pending[half][count[half]++] = static_cast<int32_t>(i);
  }

  // The neighbours, in the bits' order.
  std::array<int64_t, 8> steps() const {
    return {-stride, 1 - stride, 1, stride + 1, stride, stride - 1, -1, -stride - 1};
  }

  template <class T>
  void begin(const T* x) {
    std::fill_n(set, (height + 2) * stride, uint8_t{0});
    std::fill_n(waiting, (height + 2) * stride, uint8_t{0});
    count[0] = count[1] = 0;
    for (int64_t y = 0; y < height; ++y)
      for (int64_t c = 0; c < width; ++c) set[(y + 1) * stride + c + 1] = x[y * width + c] > 0;
    for (int64_t y = 1; y <= height; ++y) {
      const uint8_t* const from = set + y * stride + 1;
      uint8_t* const to = ring + y * stride + 1;
      for_lanes<uint8_t>(width, [=, at = steps()](auto d, auto, int64_t k) {
        auto bits = hn::LoadU(d, from + k + at[7]);
        for (size_t n = 7; n-- > 0;) bits = hn::Add(hn::Add(bits, bits), hn::LoadU(d, from + k + at[n]));
        hn::StoreU(bits, d, to + k);
      });
      for (int64_t i = y * stride + 1; i <= y * stride + width; ++i)
        for (int half = 0; half < 2; ++half)
          if (set[i] && goes[half][ring[i]]) wait(i, half);
    }
  }

  void peel(int half) {
    int64_t going = 0;
    for (int64_t k = 0; k < count[half]; ++k) {
      const int32_t i = pending[half][k];
      waiting[i] = static_cast<uint8_t>(waiting[i] & ~(1 << half));
      if (set[i] && goes[half][ring[i]]) gone[going++] = i;
    }
    count[half] = 0;
    const auto at = steps();
    for (int64_t k = 0; k < going; ++k) set[gone[k]] = 0;
    for (int64_t k = 0; k < going; ++k)
      for (unsigned n = 0; n < 8; ++n) {
        const int64_t i = gone[k] + at[n];
        ring[i] = static_cast<uint8_t>(ring[i] & ~(1u << (n + 4) % 8));
        if (!set[i]) continue;
        wait(i, 0);
        wait(i, 1);
      }
  }
};

}  // namespace

template <class T>
void thin(const T* x, Planes planes, int64_t limit, bool zhang, T* out) {
  Table goes[2];
  for (unsigned ring = 0; ring < 256; ++ring)
    for (int half = 0; half < 2; ++half)
      goes[half][ring] = zhang ? zhang_suen(ring, half == 0) : guo_hall(ring, half == 0);
  const int64_t height = planes.height, width = planes.width, stride = width + 2,
                padded = (height + 2) * stride, size = height * width;
  const auto threads = static_cast<size_t>(omp_get_max_threads());
  const std::unique_ptr<uint8_t[]> bytes(new uint8_t[static_cast<size_t>(3 * padded) * threads]);
  const std::unique_ptr<int32_t[]> lists(new int32_t[static_cast<size_t>(3 * size) * threads]);
#pragma omp parallel for
  for (int64_t plane = 0; plane < planes.count; ++plane) {
    const int64_t thread = omp_get_thread_num();
    uint8_t* const own = bytes.get() + 3 * padded * thread;
    int32_t* const list = lists.get() + 3 * size * thread;
    Peeling peeling{goes,
                    height,
                    width,
                    stride,
                    own,
                    own + padded,
                    own + 2 * padded,
                    {list, list + size},
                    list + 2 * size,
                    {}};
    peeling.begin(x + plane * size);
    for (int64_t k = 0; k < limit && peeling.count[0] + peeling.count[1] > 0; ++k)
      for (int half = 0; half < 2; ++half) peeling.peel(half);
    for (int64_t y = 0; y < height; ++y)
      for (int64_t c = 0; c < width; ++c)
        out[(plane * height + y) * width + c] = static_cast<T>(peeling.set[(y + 1) * stride + c + 1]);
  }
}

CHIASM_INSTANTIATE(thin)

}  // namespace chiasm::kernels
