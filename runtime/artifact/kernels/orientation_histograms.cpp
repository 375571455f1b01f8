// Histograms of gradients' directions in patches, for descriptors and orientations.
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "declared/orientation_histograms.h"
#include "functions.h"
#include "lanes.h"

namespace chiasm::kernels {
namespace {

// The weighted lengths and the positions among the bins for a row's n gradients (dx, dy). Returns whether all
// lengths are finite. Rows are whole vectors long.
template <class T>
bool to_polar(const T* dx, const T* dy, const T* weight, int64_t n, T bins, T* length, T* place) {
  const Lanes<T> d;
  const auto turn = hn::Set(d, static_cast<T>(bins / (2 * M_PI)));
  auto rest = hn::Zero(d);  // becomes NaN if a length is NaN or infinite
  for (int64_t i = 0; i < n; i += kLanes<T>) {
    const auto x = hn::LoadU(d, dx + i), y = hn::LoadU(d, dy + i), angle = hn::Mul(vector_atan2(y, x), turn);
    const auto weighed = hn::Mul(hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(y, y))), hn::LoadU(d, weight + i));
    rest = hn::Add(rest, hn::Sub(weighed, weighed));
    hn::StoreU(weighed, d, length + i);
    hn::StoreU(hn::Add(angle, hn::IfThenElseZero(hn::Lt(angle, hn::Zero(d)), hn::Set(d, bins))), d,
               place + i);
  }
  return !any(d, hn::IsNaN(rest));
}

}  // namespace

template <class T>
void orientation_histograms(const T* patches, int64_t count, int64_t size, const T* window,
                            const T* space_weights, int64_t places, int64_t bins, T* out) {
  constexpr int64_t lanes = kLanes<T>;
  const int64_t padded = (size + lanes - 1) / lanes * lanes, room = 5 * padded + bins * places;
  std::vector<T> scratch(static_cast<size_t>(room * omp_get_max_threads()));
  std::vector<int64_t> first(static_cast<size_t>(size)), last(first);  // the spatial bins of a pixel
  for (int64_t i = 0; i < size; ++i) {
    while (first[i] < places && space_weights[first[i] * size + i] == 0) ++first[i];
    last[i] = places;
    while (last[i] > first[i] && space_weights[(last[i] - 1) * size + i] == 0) --last[i];
  }
#pragma omp parallel for
  for (int64_t patch = 0; patch < count; ++patch) {
    const T* const image = patches + patch * size * size;
    T* const histogram = out + patch * bins * places * places;
    T *const dx = scratch.data() + room * omp_get_thread_num(), *const dy = dx + padded,
             *const length = dy + padded, *const place = length + padded;
    T *const weight = place + padded, *const row = weight + padded;
    std::fill_n(histogram, bins * places * places, T(0));
    const auto same = [&](T pixel) { return pixel == *image; };
    // a patch of an empty slot
    if (size && std::isfinite(*image) && std::all_of(image, image + size * size, same)) continue;
    bool defined = true;
    for (int64_t y = 0; y < size; ++y) {
      const T *const here = image + y * size, *const above = y ? here - size : here,
                     *const below = y + 1 < size ? here + size : here;
      for (int64_t i = 0; i < size; ++i) {
        dx[i] = T(0.5) * (here[std::min(i + 1, size - 1)] - here[std::max<int64_t>(i - 1, 0)]);
        dy[i] = T(0.5) * (below[i] - above[i]);
        weight[i] = window[y * size + i];
      }
      defined &= to_polar(dx, dy, weight, padded, static_cast<T>(bins), length, place);
      std::fill_n(row, bins * places, T(0));
      for (int64_t i = 0; i < size; ++i) {
        const T whole = std::floor(place[i]), far = (place[i] - whole) * length[i], near = length[i] - far;
        const int64_t bin = whole == whole ? static_cast<int64_t>(whole) : 0;
        const int64_t low = bin < bins ? bin : 0, high = low + 1 < bins ? low + 1 : 0;
        for (int64_t k = first[i]; k < last[i]; ++k) {
          const T share = space_weights[k * size + i];
          row[low * places + k] += near * share;
          row[high * places + k] += far * share;
        }
      }
      for (int64_t k = first[y]; k < last[y]; ++k)
        for (int64_t bin = 0; bin < bins; ++bin)
          for (int64_t i = 0; i < places; ++i)
            histogram[(bin * places + k) * places + i] += space_weights[k * size + y] * row[bin * places + i];
    }
    // As if all pixels contributed to all bins, most of them with weight 0.
    if (!defined) std::fill_n(histogram, bins * places * places, std::numeric_limits<T>::quiet_NaN());
  }
}

CHIASM_INSTANTIATE(orientation_histograms)

}  // namespace chiasm::kernels
