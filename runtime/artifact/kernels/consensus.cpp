// Random sample consensus: the models with the least cost. Most models cost too much after a part of the
// points, and are abandoned there.
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "declared/consensus.h"
#include "lanes.h"

namespace chiasm::kernels {
namespace {

constexpr int64_t kBlock = 128;  // points between two checks of the cost so far

// The number of partial sums does not depend on the CPU's vectors, so that costs are rounded in the same way.
template <class T>
constexpr int64_t kSeries = 32 / sizeof(T);
template <class T>
using Part = hn::CappedTag<T, kSeries<T>>;

// The errors of model m at the points (x, y) and (u, v) of a vector.
template <bool kEpipolar, class D, class T, class V>
HWY_INLINE V errors_of(D d, const T* m, V x, V y, V u, V v) {
  const auto affine = [=](int a, V p, int b, V q, int c) {
    return hn::Add(hn::Add(hn::Mul(hn::Set(d, m[a]), p), hn::Mul(hn::Set(d, m[b]), q)), hn::Set(d, m[c]));
  };
  const auto square = [](V p) { return hn::Mul(p, p); };
  const V a = affine(0, x, 1, y, 2), b = affine(3, x, 4, y, 5), c = affine(6, x, 7, y, 8);
  if constexpr (kEpipolar) {
    const V s = affine(0, u, 3, v, 6), t = affine(1, u, 4, v, 7),
            product = hn::Add(hn::Add(hn::Mul(a, u), hn::Mul(b, v)), c);
    return hn::Div(square(product), hn::Add(hn::Add(hn::Add(square(a), square(b)), square(s)), square(t)));
  } else {
    const V inverse_depth = hn::Div(hn::Set(d, T(1)), c);
    return hn::Add(square(hn::Sub(hn::Mul(a, inverse_depth), u)),
                   square(hn::Sub(hn::Mul(b, inverse_depth), v)));
  }
}

// The errors at the points from i on, each at most its point's bound. If one of both is NaN, the error is
// returned.
template <bool kEpipolar, class D, class T>
HWY_INLINE hn::Vec<D> costs_at(D d, const T* model, const T* planes, int64_t n, int64_t i) {
  const auto row = [=](int64_t k) { return hn::LoadU(d, planes + k * n + i); };
  return smaller(row(6), errors_of<kEpipolar>(d, model, row(0), row(1), row(3), row(4)));
}

template <class T>
T total(const T* sums) {
  T sum = 0;
  for (int64_t k = 0; k < kSeries<T>; ++k) sum += sums[k];
  return sum;
}

// The model's cost, or infinity if the cost is more than `most` or NaN.
template <bool kEpipolar, class T>
T cost_of(const T* model, const T* planes, int64_t n, T most) {
  const Part<T> d;
  constexpr auto lanes = static_cast<int64_t>(hn::MaxLanes(d)), parts = kSeries<T> / lanes;
  const int64_t whole = n - n % kSeries<T>;
  T own[9], sums[kSeries<T>] = {};
  std::copy_n(model, 9, own);
  hn::Vec<Part<T>> sum[parts];
  for (auto& s : sum) s = hn::Zero(d);
  int64_t i = 0;
  while (i < whole) {
    for (const int64_t end = std::min(whole, i + kBlock); i < end; i += kSeries<T>)
      for (int64_t p = 0; p < parts; ++p)
        sum[p] = hn::Add(sum[p], costs_at<kEpipolar>(d, own, planes, n, i + p * lanes));
    for (int64_t p = 0; p < parts; ++p) hn::StoreU(sum[p], d, sums + p * lanes);
    if (total(sums) > most) return std::numeric_limits<T>::infinity();
  }
  T cost = total(sums);
  for (; i < n; ++i) cost += hn::GetLane(costs_at<kEpipolar>(Lane<T>(), own, planes, n, i));
  return cost <= most ? cost : std::numeric_limits<T>::infinity();
}

// Models with their costs, the cheapest first; ties by the lower index.
template <class T>
using Ranking = std::vector<std::pair<T, int64_t>>;

// Puts the cheapest `count` into `ranking`, which has room for one more.
template <bool kEpipolar, class T>
void cheapest(const T* models, int64_t begin, int64_t end, const T* planes, int64_t n, int64_t count,
              Ranking<T>& ranking) {
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
void score_models(const T* models, int64_t batch, int64_t per_item, const T* points, int64_t n, bool epipolar,
                  int64_t count, int64_t* out) {
  const int64_t parts = omp_get_max_threads();
  std::vector<Ranking<T>> rankings(static_cast<size_t>(batch * parts));
  // Allocated here, because nothing may be thrown inside the parallel region.
  for (Ranking<T>& ranking : rankings) ranking.reserve(static_cast<size_t>(std::min(count, per_item) + 1));
#pragma omp parallel for
  for (int64_t i = 0; i < batch * parts; ++i) {
    const int64_t item = i / parts, part = i % parts, begin = per_item * part / parts,
                  end = per_item * (part + 1) / parts;
    const T *const own = models + item * per_item * 9, *const rows = points + item * 7 * n;
    if (epipolar)
      cheapest<true>(own, begin, end, rows, n, count, rankings[i]);
    else
      cheapest<false>(own, begin, end, rows, n, count, rankings[i]);
  }
  for (int64_t item = 0; item < batch; ++item) {
    Ranking<T> all;
    for (int64_t part = 0; part < parts; ++part)
      all.insert(all.end(), rankings[item * parts + part].begin(), rankings[item * parts + part].end());
    std::sort(all.begin(), all.end());
    for (int64_t k = 0; k < count; ++k)
      out[item * count + k] = k < static_cast<int64_t>(all.size()) ? all[k].second : 0;
  }
}

CHIASM_INSTANTIATE(score_models)

}  // namespace chiasm::kernels
