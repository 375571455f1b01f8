// Key points of scale space: the strongest pixels that exceed all of their 26 neighbours, or are below all of
// them.
#include <omp.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "declared/scale_space_nms.h"
#include "lanes.h"

namespace chiasm::kernels {
namespace {

// Widens the ranges from `least` to `most` by the 3 x 3 values around each value from p on, with `own`
// without the value itself. With NaN the ranges may be too narrow.
template <class D, class T>
HWY_INLINE void widen(D d, const T* p, int64_t row, bool own, hn::Vec<D>& most, hn::Vec<D>& least) {
  for (int64_t y = -1; y <= 1; ++y)
    for (int64_t x = -1; x <= 1; ++x) {
      if (own && x == 0 && y == 0) continue;
      const auto value = hn::LoadU(d, p + y * row + x);
      most = larger(most, value);
      least = smaller(least, value);
    }
}

// One bit for each lane.
template <class D>
HWY_INLINE uint32_t bits(D d, hn::Mask<D> mask) {
  static_assert(hn::MaxLanes(D()) <= 16);
  uint8_t bytes[8];  // as many as StoreMaskBits may write
  hn::StoreMaskBits(d, mask, bytes);
  uint32_t number = bytes[0];
  if (hn::MaxLanes(D()) > 8) number |= static_cast<uint32_t>(bytes[1]) << 8;
  return number;
}

// One bit for each value from p on, set if there is NaN around it. Rarely called, so not inlined: it would
// take the loop's registers.
template <class D, class T>
__attribute__((noinline)) uint32_t unordered(D d, const T* p, int64_t row, int64_t plane) {
  const auto is_nan = [=](int64_t i) {
    return hn::IsNaN(hn::LoadU(d, p + (i / 9 - 1) * plane + (i / 3 % 3 - 1) * row + i % 3 - 1));
  };
  auto found = is_nan(0);
  for (int64_t i = 1; i < 27; ++i) found = hn::Or(found, is_nan(i));
  return bits(d, found);
}

// One bit for each value from p on, set if it is an extremum: a positive maximum or, with `minima`, a
// negative minimum.
template <class D, class T>
HWY_INLINE uint32_t extrema(D d, const T* p, int64_t row, int64_t plane, bool minima) {
  const auto centre = hn::LoadU(d, p), zero = hn::Zero(d);
  auto most = hn::LoadU(d, p - 1), least = most;
  widen(d, p, row, true, most, least);
  const auto found = [&] {
    const auto maximum = hn::And(hn::Gt(centre, most), hn::Gt(centre, zero));
    return minima ? hn::Or(maximum, hn::And(hn::Lt(centre, least), hn::Lt(centre, zero))) : maximum;
  };
  if (!any(d, found())) return 0;  // the planes above and below rarely need to be read
  widen(d, p - plane, row, false, most, least);
  widen(d, p + plane, row, false, most, least);
  const uint32_t set = bits(d, found());
  return set ? set & ~unordered(d, p, row, plane) : 0;  // a value next to NaN is not an extremum
}

}  // namespace

template <class T>
void scale_space_nms(const T* x, Images volumes, const int64_t* margins, bool minima, int64_t count,
                     int64_t* out) {
  const int64_t levels = volumes.channels, height = volumes.height, width = volumes.width,
                plane = height * width;
  if (levels < 3) {
    std::fill_n(out, volumes.count * count, -1);
    return;
  }
  // Allocated here, because nothing may be thrown inside the parallel region: the columns of each row's
  // extrema.
  const int64_t rows = (levels - 2) * height;
  const std::unique_ptr<int32_t[]> columns(new int32_t[static_cast<size_t>(rows * width)]);
  std::vector<int32_t> counts(static_cast<size_t>(rows));
  std::vector<std::pair<T, int64_t>> found;
  for (int64_t item = 0; item < volumes.count; ++item, out += count) {
    const T* const volume = x + item * levels * plane;
#pragma omp parallel for
    for (int64_t i = 0; i < rows; ++i) {
      const int64_t level = 1 + i / height, y = i % height, margin = std::max<int64_t>(margins[level], 1);
      const T* const row = volume + level * plane + y * width;
      int32_t* const own = columns.get() + i * width;
      int32_t n = 0;
      if (y >= margin && y < height - margin) {
        int64_t column = margin;
        for (; column + kLanes<T> <= width - margin; column += kLanes<T>)
          for (uint32_t set = extrema(Lanes<T>(), row + column, width, plane, minima); set; set &= set - 1)
            own[n++] = static_cast<int32_t>(column + __builtin_ctz(set));
        for (; column < width - margin; ++column)
          if (extrema(Lane<T>(), row + column, width, plane, minima)) own[n++] = static_cast<int32_t>(column);
      }
      counts[static_cast<size_t>(i)] = n;
    }
    found.clear();
    for (int64_t i = 0; i < rows; ++i)
      for (int32_t k = 0; k < counts[static_cast<size_t>(i)]; ++k) {
        const int64_t place = plane + i * width + columns[static_cast<size_t>(i * width + k)];
        found.emplace_back(volume[place] < 0 ? volume[place] : -volume[place], place);
      }
    // By negated strength; ties by position.
    const int64_t kept = std::min<int64_t>(count, static_cast<int64_t>(found.size()));
    std::partial_sort(found.begin(), found.begin() + kept, found.end());
    for (int64_t k = 0; k < count; ++k) out[k] = k < kept ? found[static_cast<size_t>(k)].second : -1;
  }
}

CHIASM_INSTANTIATE(scale_space_nms)

}  // namespace chiasm::kernels
