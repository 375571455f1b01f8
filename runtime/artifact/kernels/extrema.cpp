// Key points of scale space: the strongest of the places that exceed their 26 neighbours, or fall below them all.
#include <omp.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "kernels.h"
#include "vectors.h"

namespace chiasm::kernels {
namespace {

// Widens the range from `least` to `most` by the 3 x 3 values around p, without p's own where `own`. NaN leaves it too narrow, or empty.
template <class V, class Load>
inline void widen(const Load& load, const typename V::Scalar* p, int64_t row, bool own, typename V::Value& most, typename V::Value& least) {
  for (int64_t y = -1; y <= 1; ++y)
    for (int64_t x = -1; x <= 1; ++x) {
      if (own && x == 0 && y == 0) continue;
      const auto value = load(p + y * row + x);
      most = V::larger(most, value);
      least = V::smaller(least, value);
    }
}

template <class T>
struct Lanes {
  using Scalar = T;
  using Value = typename Vector<T>::Type;
  static constexpr int64_t kCount = Vector<T>::kLanes;
  static Value zero() { return Vector<T>::all(0); }
  static Value larger(Value a, Value b) { return Vector<T>::max(a, b); }
  static Value smaller(Value a, Value b) { return Vector<T>::min(a, b); }
};

template <class T>
struct Single {
  using Scalar = T;
  using Value = T;
  static constexpr int64_t kCount = 1;
  static Value zero() { return 0; }
  static Value larger(Value a, Value b) { return std::max(a, b); }
  static Value smaller(Value a, Value b) { return std::min(a, b); }
};

inline int bits(Vector<float>::Mask m) { return _mm256_movemask_ps((__m256)m); }
inline int bits(Vector<double>::Mask m) { return _mm256_movemask_pd((__m256d)m); }
inline int bits(bool m) { return m ? 1 : 0; }

// One bit for each of the values around p that are NaN somewhere. Seldom called, and not to take the loop's registers.
template <class V, class Load>
__attribute__((noinline)) int unordered(const Load& load, const typename V::Scalar* p, int64_t row, int64_t plane) {
  int found = 0;
  for (int64_t i = 0; i < 27; ++i) {
    const auto value = load(p + (i / 9 - 1) * plane + (i / 3 % 3 - 1) * row + i % 3 - 1);
    found |= bits(value != value);
  }
  return found;
}

// One bit for each of the values from p on that is an extremum: a positive maximum or, with `minima`, a negative minimum.
template <class V, class Load>
inline int extrema(const Load& load, const typename V::Scalar* p, int64_t row, int64_t plane, bool minima) {
  const auto centre = load(p), zero = V::zero();
  auto most = load(p - 1), least = most;
  widen<V>(load, p, row, true, most, least);
  const auto found = [&] { return bits((centre > most) & (centre > zero)) | (minima ? bits((centre < least) & (centre < zero)) : 0); };
  if (!found()) return 0;  // seldom is there anything to be seen in the planes above and below
  widen<V>(load, p - plane, row, false, most, least);
  widen<V>(load, p + plane, row, false, most, least);
  const int set = found();
  return set ? set & ~unordered<V>(load, p, row, plane) : 0;  // beside NaN nothing is an extremum
}

}  // namespace

template <class T>
void strongest_extrema(const T* x, Images volumes, const int64_t* margins, bool minima, int64_t count, int64_t* out) {
  const int64_t levels = volumes.channels, height = volumes.height, width = volumes.width, plane = height * width;
  if (levels < 3) {
    std::fill_n(out, volumes.count * count, -1);
    return;
  }
  // Allocated here, because nothing may be thrown inside the parallel region: for each row its extrema's columns.
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
        for (; column + Lanes<T>::kCount <= width - margin; column += Lanes<T>::kCount)
          for (int set = extrema<Lanes<T>>(Vector<T>::load, row + column, width, plane, minima); set; set &= set - 1)
            own[n++] = static_cast<int32_t>(column + __builtin_ctz(static_cast<unsigned>(set)));
        for (; column < width - margin; ++column)
          if (extrema<Single<T>>([](const T* p) { return *p; }, row + column, width, plane, minima)) own[n++] = static_cast<int32_t>(column);
      }
      counts[static_cast<size_t>(i)] = n;
    }
    found.clear();
    for (int64_t i = 0; i < rows; ++i)
      for (int32_t k = 0; k < counts[static_cast<size_t>(i)]; ++k) {
        const int64_t place = plane + i * width + columns[static_cast<size_t>(i * width + k)];
        found.emplace_back(volume[place] < 0 ? volume[place] : -volume[place], place);
      }
    // By strength, negated, and of equals by place.
    const int64_t kept = std::min<int64_t>(count, static_cast<int64_t>(found.size()));
    std::partial_sort(found.begin(), found.begin() + kept, found.end());
    for (int64_t k = 0; k < count; ++k) out[k] = k < kept ? found[static_cast<size_t>(k)].second : -1;
  }
}

template void strongest_extrema(const float*, Images, const int64_t*, bool, int64_t, int64_t*);
template void strongest_extrema(const double*, Images, const int64_t*, bool, int64_t, int64_t*);

}  // namespace chiasm::kernels
