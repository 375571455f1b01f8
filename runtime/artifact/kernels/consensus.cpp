// Random sample consensus: which of many models cost least. Most cost too much after a part of the points, and are left there.
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "kernels.h"
#include "vectors.h"

namespace chiasm::kernels {
namespace {

constexpr int64_t kBlock = 128;  // points between two looks at the cost so far

// The error of model m at the points (x, y) and (u, v); V is one value or a vector of them.
template <bool kEpipolar, class T, class V>
inline V error_of(const T* m, V x, V y, V u, V v) {
  const V a = m[0] * x + m[1] * y + m[2], b = m[3] * x + m[4] * y + m[5], c = m[6] * x + m[7] * y + m[8];
  if constexpr (kEpipolar) {
    const V d = m[0] * u + m[3] * v + m[6], e = m[1] * u + m[4] * v + m[7], product = a * u + b * v + c;
    return product * product / (a * a + b * b + d * d + e * e);
  } else {
    const V inverse_depth = T(1) / c, dx = a * inverse_depth - u, dy = b * inverse_depth - v;
    return dx * dx + dy * dy;
  }
}

template <class T>
T total(typename Vector<T>::Type v) {
  T lanes[Vector<T>::kLanes], sum = 0;
  Vector<T>::store(lanes, v);
  for (const T lane : lanes) sum += lane;
  return sum;
}

// The model's cost where it is at most `most`; what costs more, or is not a number, costs infinity.
template <bool kEpipolar, class T>
T cost_of(const T* model, const T* planes, int64_t n, T most) {
  using V = Vector<T>;
  const T *const x = planes, *const y = planes + n, *const u = planes + 3 * n, *const v = planes + 4 * n, *const bound = planes + 6 * n;
  const int64_t whole = n - n % V::kLanes;
  auto sums = V::all(0);
  int64_t i = 0;
  while (i < whole) {
    // The second is taken where either is not a number.
    for (const int64_t end = std::min(whole, i + kBlock); i < end; i += V::kLanes)
      sums += V::min(V::load(bound + i), error_of<kEpipolar>(model, V::load(x + i), V::load(y + i), V::load(u + i), V::load(v + i)));
    if (total<T>(sums) > most) return std::numeric_limits<T>::infinity();
  }
  T cost = total<T>(sums);
  for (; i < n; ++i) {
    const T error = error_of<kEpipolar>(model, x[i], y[i], u[i], v[i]);
    cost += error > bound[i] ? bound[i] : error;
  }
  return cost <= most ? cost : std::numeric_limits<T>::infinity();
}

// Models with their costs, the least first, of equals the first.
template <class T>
using Ranking = std::vector<std::pair<T, int64_t>>;

// Puts the cheapest `count` into `ranking`, which has room for one more.
template <bool kEpipolar, class T>
void cheapest(const T* models, int64_t begin, int64_t end, const T* planes, int64_t n, int64_t count, Ranking<T>& ranking) {
  T most = std::numeric_limits<T>::max();
  for (int64_t i = begin; i < end; ++i) {
    const std::pair<T, int64_t> entry(cost_of<kEpipolar>(models + 9 * i, planes, n, most), i);
    if (!std::isfinite(entry.first)) continue;
    ranking.insert(std::upper_bound(ranking.begin(), ranking.end(), entry), entry);
    if (static_cast<int64_t>(ranking.size()) > count) ranking.pop_back();
    if (static_cast<int64_t>(ranking.size()) == count) most = ranking.back().first;
  }
}

}  // namespace

template <class T>
void cheapest_models(const T* models, const T* planes, int64_t batch, int64_t per_item, int64_t n, bool epipolar, int64_t count, int64_t* out) {
  const int64_t parts = omp_get_max_threads();
  std::vector<Ranking<T>> rankings(static_cast<size_t>(batch * parts));
  // Allocated here, because nothing may be thrown inside the parallel region.
  for (Ranking<T>& ranking : rankings) ranking.reserve(static_cast<size_t>(std::min(count, per_item) + 1));
#pragma omp parallel for
  for (int64_t i = 0; i < batch * parts; ++i) {
    const int64_t item = i / parts, part = i % parts, begin = per_item * part / parts, end = per_item * (part + 1) / parts;
    const T *const own = models + item * per_item * 9, *const points = planes + item * 7 * n;
    if (epipolar) cheapest<true>(own, begin, end, points, n, count, rankings[i]);
    else cheapest<false>(own, begin, end, points, n, count, rankings[i]);
  }
  for (int64_t item = 0; item < batch; ++item) {
    Ranking<T> all;
    for (int64_t part = 0; part < parts; ++part) all.insert(all.end(), rankings[item * parts + part].begin(), rankings[item * parts + part].end());
    std::sort(all.begin(), all.end());
    for (int64_t k = 0; k < count; ++k) out[item * count + k] = k < static_cast<int64_t>(all.size()) ? all[k].second : 0;
  }
}

template void cheapest_models(const float*, const float*, int64_t, int64_t, int64_t, bool, int64_t, int64_t*);
template void cheapest_models(const double*, const double*, int64_t, int64_t, int64_t, bool, int64_t, int64_t*);

}  // namespace chiasm::kernels
