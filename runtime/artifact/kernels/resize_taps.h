// The pixels that resizing and blurring sum along an axis, and their weights.
#pragma once

#include <cstdint>
#include <vector>

#include "declared/types.h"

namespace chiasm::kernels {

// Along an axis each of `count` pixels is the sum of `each` pixels, index[i * each + k], by weights.
template <class T>
struct Taps {
  Taps(int64_t count, int64_t each) : count(count), each(each), index(count * each), weight(count * each) {}
  void put(int64_t i, int64_t k, int64_t pixel, T value) {
    index[i * each + k] = static_cast<int32_t>(pixel);
    weight[i * each + k] = value;
  }

  int64_t count, each;
  std::vector<int32_t> index;
  std::vector<T> weight;
};

// For resizing `in` pixels to `out`, as declared for the kernel `resize`.
template <class T>
Taps<T> resize_taps(int64_t in, int64_t out, Interpolation mode, bool align_corners, bool antialias);

// Composes taps with a preceding blur: applying the result to `size` pixels equals resampling the blurred
// pixels. The kernel's length is odd.
template <class T>
Taps<T> blurred_before(const Taps<T>& taps, const std::vector<T>& kernel, Border border, int64_t size);

// Composes taps with a blur after them.
template <class T>
Taps<T> blurred_after(const Taps<T>& taps, const std::vector<T>& kernel, Border border);

// Pixel (y, x) of the output is the sum by the taps of `down` for y and of `across` for x. Pixels with a
// weight of 0 may be read, also beside those that the taps name: an infinite value or NaN there gives NaN.
template <class T>
void resample(const T* x, Planes planes, const Taps<T>& down, const Taps<T>& across, T* out);

}  // namespace chiasm::kernels
