// Non-maximum suppression: decides which of the overlapping boxes are kept, from the first box to the last.
#include <algorithm>
#include <numeric>

#include "declared/boxes.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// The kept boxes of one group, coordinate by coordinate, as a part of arrays for all groups.
template <class T>
struct Kept {
  T *left, *top, *right, *bottom, *area;

  // Whether one of `count` boxes overlaps another box by more than this part of their union.
  bool overlap(int64_t count, const T* box, T box_area, T threshold) const {
    const Kept kept = *this;
    bool found = false;
    const auto compare = [=](auto d, int64_t k) {
      const auto side = [=](const T* low, const T* high, int axis) {
        const auto begin = larger(hn::LoadU(d, low + k), hn::Set(d, box[axis]));
        const auto end = smaller(hn::LoadU(d, high + k), hn::Set(d, box[axis + 2]));
        return larger(hn::Sub(end, begin), hn::Zero(d));
      };
      const auto common = hn::Mul(side(kept.left, kept.right, 0), side(kept.top, kept.bottom, 1));
      const auto both = hn::Sub(hn::Add(hn::LoadU(d, kept.area + k), hn::Set(d, box_area)), common);
      return any(d, hn::Gt(common, hn::Mul(hn::Set(d, threshold), both)));
    };
    int64_t k = 0;
    for (; !found && k + kLanes<T> <= count; k += kLanes<T>) found = compare(Lanes<T>(), k);
    for (; !found && k < count; ++k) found = compare(Lane<T>(), k);
    return found;
  }

  void add(int64_t k, const T* box, T box_area) const {
    left[k] = box[0];
    top[k] = box[1];
    right[k] = box[2];
    bottom[k] = box[3];
    area[k] = box_area;
  }
};

}  // namespace

template <class T>
void nms(const T* boxes, int64_t images, int64_t n, const int64_t* groups, T threshold, int64_t most,
         bool* out) {
  const auto count = static_cast<size_t>(n);
  // For each image: where the part of each group begins, and how many of its boxes have been kept.
  const auto places = static_cast<size_t>(images) * count;
  std::vector<int64_t> order(places), part(places), kept(places);
  std::vector<T> memory(5 * places);
#pragma omp parallel for
  for (int64_t image = 0; image < images; ++image) {
    const int64_t first = image * n;
    const int64_t* const group = groups + first;
    int64_t *const sorted = order.data() + first, *const begin = part.data() + first;
    std::iota(sorted, sorted + n, int64_t{0});
    std::sort(sorted, sorted + n,
              [=](int64_t a, int64_t b) { return group[a] != group[b] ? group[a] < group[b] : a < b; });
    for (int64_t i = 0; i < n; ++i)
      begin[sorted[i]] = i > 0 && group[sorted[i]] == group[sorted[i - 1]] ? begin[sorted[i - 1]] : i;
    T* const own = memory.data() + 5 * first;
    int64_t chosen = 0;
    for (int64_t i = 0; i < n; ++i) {
      const T* const box = boxes + 4 * (first + i);
      out[first + i] = false;
      if (chosen >= most) continue;
      const T area = (box[2] - box[0]) * (box[3] - box[1]);
      const int64_t at = begin[i];
      int64_t& taken = kept[static_cast<size_t>(first + at)];
      const Kept<T> others{own + at, own + n + at, own + 2 * n + at, own + 3 * n + at, own + 4 * n + at};
      // A box with NaN overlaps nothing.
      const bool known = std::all_of(box, box + 4, [](T x) { return x == x; });
      if (known && others.overlap(taken, box, area, threshold)) continue;
      out[first + i] = true;
      ++chosen;
      if (known) others.add(taken++, box, area);
    }
  }
}

CHIASM_INSTANTIATE(nms)

}  // namespace chiasm::kernels
