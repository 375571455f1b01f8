// Canny's gradient and its maxima, row by row.
#include "rows.h"

namespace chiasm::kernels {
namespace {

// The loops over a row are functions of values, not of references, for the reason given in extremes.cpp.

template <class T>
void smooth_and_slope(const T* above, const T* here, const T* below, int64_t n, T* smooth, T* slope) {
  using V = Vector<T>;
  int64_t k = 0;
  for (; k + V::kLanes <= n; k += V::kLanes) {
    const auto a = V::load(above + k), c = V::load(below + k);
    V::store(smooth + k, a + V::all(2) * V::load(here + k) + c);
    V::store(slope + k, c - a);
  }
  for (; k < n; ++k) {
    smooth[k] = above[k] + 2 * here[k] + below[k];
    slope[k] = below[k] - above[k];
  }
}

// Beyond the end too, up to a whole vector, for which the rows have room.
template <class T>
void magnitudes(const T* smooth, const T* slope, int64_t n, T eps, T* dx, T* dy, T* magnitude) {
  using V = Vector<T>;
  for (int64_t k = 0; k < n; k += V::kLanes) {
    const auto x = V::load(smooth + k + 1) - V::load(smooth + k - 1);
    const auto y = V::load(slope + k - 1) + V::all(2) * V::load(slope + k) + V::load(slope + k + 1);
    V::store(dx + k, x);
    V::store(dy + k, y);
    V::store(magnitude + k, V::sqrt(V::max(x * x + y * y + V::all(eps), V::all(0))));
  }
}

// The gradient of three rows of a tile around the one that is thinned, as a ring; one column more at either end.
template <class T>
class Gradient {
 public:
  static constexpr int64_t kRows = 3 * 3 + 2;  // of scratch

  Gradient(const T* image, const Planes& planes, const Tile& tile, T eps, T* scratch, int64_t length)
      : image_(image), height_(planes.height), width_(planes.width), tile_(tile), eps_(eps), length_(length), scratch_(scratch) {}

  T* magnitude(int64_t y) const { return row((y + 3) % 3); }
  T* dx(int64_t y) const { return row(3 + (y + 3) % 3); }
  T* dy(int64_t y) const { return row(6 + (y + 3) % 3); }

  void compute(int64_t y) const {
    const int64_t columns = tile_.right - tile_.left;
    T *const m = magnitude(y), *const smooth = row(9), *const slope = row(10);
    if (y < 0 || y >= height_) {
      std::fill_n(m - 1, columns + 2, T(0));
      return;
    }
    const Span span(tile_, width_, 2, 2);
    const int64_t start = span.first - tile_.left;
    const T* const here = image_ + y * width_ + span.first;
    smooth_and_slope(y > 0 ? here - width_ : here, here, y + 1 < height_ ? here + width_ : here, span.count(), smooth + start, slope + start);
    extend(smooth, tile_, width_, 2, 2, Border::kReplicate, T(0));
    extend(slope, tile_, width_, 2, 2, Border::kReplicate, T(0));
    magnitudes(smooth - 1, slope - 1, columns + 2, eps_, dx(y) - 1, dy(y) - 1, m - 1);
    if (tile_.left == 0) m[-1] = 0;
    if (tile_.right == width_) m[columns] = 0;
  }

 private:
  T* row(int64_t i) const { return scratch_ + i * length_ + 2; }

  const T* const image_;
  const int64_t height_, width_;
  const Tile tile_;
  const T eps_;
  const int64_t length_;
  T* const scratch_;
};

// The magnitude at m[0] where it is a ridge across the gradient's direction, rounded to 45 degrees, else 0.
template <class T>
inline auto thinned(const T* above, const T* here, const T* below, const T* dx, const T* dy) {
  using V = Vector<T>;
  const auto centre = V::load(here), x = V::load(dx), y = V::load(dy);
  const auto tangent = V::all(static_cast<T>(0.41421356237309503));  // of 22.5 degrees
  const auto wide = V::max(x, -x), high = V::max(y, -y);
  const auto horizontal = high < wide * tangent, vertical = wide < high * tangent;
  // Of two equal pixels side by side the first is the ridge.
  const auto across = (centre > V::load(here - 1)) & (centre >= V::load(here + 1));
  const auto along = (centre > V::load(above)) & (centre >= V::load(below));
  const auto falling = centre > V::max(V::load(above - 1), V::load(below + 1));
  const auto rising = centre > V::max(V::load(above + 1), V::load(below - 1));
  const auto zero = V::all(0);
  const auto same = ~((x > zero) ^ (y > zero));
  const auto diagonal = (same & falling) | (~same & rising);
  return V::where((horizontal & across) | (vertical & along) | (~horizontal & ~vertical & diagonal), centre);
}

template <class T>
void thin(const T* above, const T* here, const T* below, const T* dx, const T* dy, int64_t n, T* out) {
  using V = Vector<T>;
  int64_t k = 0;
  for (; k + V::kLanes <= n; k += V::kLanes) V::store(out + k, thinned(above + k, here + k, below + k, dx + k, dy + k));
  if (k < n) store_part<T>(out + k, thinned(above + k, here + k, below + k, dx + k, dy + k), n - k);
}

}  // namespace

template <class T>
void ridges(const T* x, Planes planes, T eps, T* out) {
  const int64_t height = planes.height, width = planes.width;
  for_tiles<T>(planes, Gradient<T>::kRows + 4, Gradient<T>::kRows, 4, Border::kReplicate, [=](const Tile& tile, T* scratch, int64_t length) {
    const Gradient<T> gradient(x + tile.plane * height * width, planes, tile, eps, scratch, length);
    gradient.compute(tile.top - 1);
    gradient.compute(tile.top);
    for (int64_t y = tile.top; y < tile.bottom; ++y) {
      gradient.compute(y + 1);
      thin(gradient.magnitude(y - 1), gradient.magnitude(y), gradient.magnitude(y + 1), gradient.dx(y), gradient.dy(y), tile.right - tile.left,
           out + (tile.plane * height + y) * width + tile.left);
    }
  });
}

template void ridges(const float*, Planes, float, float*);
template void ridges(const double*, Planes, double, double*);

}  // namespace chiasm::kernels
