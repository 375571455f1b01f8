#include "resize_taps.h"

#include <cmath>

#include "rows.h"

namespace chiasm::kernels {
namespace {

// R. Keys, Cubic Convolution Interpolation for Digital Image Processing, IEEE TASSP 29(6), 1981: the kernel
// at a distance d >= 0.
template <class T>
T cubic(T d, T a) {
  if (d < 1) return ((a + 2) * d - (a + 3)) * d * d + 1;
  return d < 2 ? ((a * d - 5 * a) * d + 8 * a) * d - 4 * a : T(0);
}

// The filter is stretched by the factor of reduction, cut at the image's border and normalised, as Pillow
// does.
template <class T>
Taps<T> antialias_taps(int64_t in, int64_t out, Interpolation mode, bool align_corners) {
  const int64_t radius = mode == Interpolation::kBilinear ? 1 : 2;
  const int64_t from = align_corners ? in - 1 : in, to = align_corners ? std::max<int64_t>(out - 1, 1) : out;
  const T factor = T(from) / T(to), stretch = std::max(factor, T(1));
  Taps<T> taps(out, 2 * radius * ((from + to - 1) / to) + 2);
  for (int64_t i = 0; i < out; ++i) {
    const T centre = (T(i) + T(0.5)) * factor,
            first = std::max(std::floor(centre - T(radius) * stretch + T(0.5)), T(0));
    T total = 0;
    for (int64_t k = 0; k < taps.each; ++k) {
      const T pixel = first + T(k), distance = std::abs(pixel + T(0.5) - centre) / stretch;
      const T weight =
          mode == Interpolation::kBilinear ? std::max(T(1) - distance, T(0)) : cubic(distance, T(-0.5));
      taps.put(i, k, std::min(static_cast<int64_t>(pixel), in - 1), pixel < T(in) ? weight : T(0));
      total += taps.weight[i * taps.each + k];
    }
    for (int64_t k = 0; k < taps.each; ++k) taps.weight[i * taps.each + k] /= total;
  }
  return taps;
}

}  // namespace

template <class T>
Taps<T> resize_taps(int64_t in, int64_t out, Interpolation mode, bool align_corners, bool antialias) {
  if (mode == Interpolation::kNearest) {
    Taps<T> taps(out, 1);
    for (int64_t i = 0; i < out; ++i) taps.put(i, 0, i * in / out, T(1));
    return taps;
  }
  if (antialias) return antialias_taps<T>(in, out, mode, align_corners);
  // Positions are ratios of integers, and only their fractions are rounded.
  const int64_t below = align_corners ? std::max<int64_t>(out - 1, 1) : 2 * out;
  Taps<T> taps(out, mode == Interpolation::kBilinear ? 2 : 4);
  for (int64_t i = 0; i < out; ++i) {
    const int64_t above = align_corners ? i * (in - 1) : (2 * i + 1) * in - out;
    // at least -1, so that the dividend is positive
    const int64_t whole = (above + below) / below - 1;
    const T t = T(above - whole * below) / T(below);
    const auto put = [&](int64_t k, int64_t pixel, T weight) {
      taps.put(i, k, std::clamp<int64_t>(pixel, 0, in - 1), weight);
    };
    if (mode == Interpolation::kBilinear) {
      put(0, whole, 1 - t);
      put(1, whole + 1, t);
    } else {
      const T distances[] = {t + 1, t, 1 - t, 2 - t};
      for (int64_t k = 0; k < 4; ++k) put(k, whole - 1 + k, cubic(distances[k], T(-0.75)));
    }
  }
  return taps;
}

template <class T>
Taps<T> blurred_before(const Taps<T>& taps, const std::vector<T>& kernel, Border border, int64_t size) {
  const auto length = static_cast<int64_t>(kernel.size());
  Taps<T> blurred(taps.count, taps.each * length);
  for (int64_t i = 0; i < taps.count * taps.each; ++i)
    for (int64_t k = 0; k < length; ++k) {
      const int64_t pixel = inside(taps.index[i] + k - length / 2, size, border);
      blurred.put(0, i * length + k, std::max<int64_t>(pixel, 0),
                  pixel < 0 ? T(0) : taps.weight[i] * kernel[k]);
    }
  return blurred;
}

template <class T>
Taps<T> blurred_after(const Taps<T>& taps, const std::vector<T>& kernel, Border border) {
  const auto length = static_cast<int64_t>(kernel.size());
  Taps<T> blurred(taps.count, taps.each * length);
  for (int64_t i = 0; i < taps.count; ++i)
    for (int64_t k = 0; k < length; ++k) {
      const int64_t near = inside(i + k - length / 2, taps.count, border);
      for (int64_t j = 0; j < taps.each; ++j) {
        const int64_t from = std::max<int64_t>(near, 0) * taps.each + j;
        blurred.put(i, k * taps.each + j, taps.index[from], near < 0 ? T(0) : kernel[k] * taps.weight[from]);
      }
    }
  return blurred;
}

#define CHIASM_TAPS(T)                                                                     \
  template Taps<T> resize_taps(int64_t, int64_t, Interpolation, bool, bool);               \
  template Taps<T> blurred_before(const Taps<T>&, const std::vector<T>&, Border, int64_t); \
  template Taps<T> blurred_after(const Taps<T>&, const std::vector<T>&, Border);
CHIASM_TAPS(float)
CHIASM_TAPS(double)
#undef CHIASM_TAPS

}  // namespace chiasm::kernels
