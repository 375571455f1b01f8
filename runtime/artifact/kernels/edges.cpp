// Sobel's gradient, and Canny's maxima of it, row by row.
#include "declared/edges.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// The loops over a row are functions of values, not of references: docs/decisions/02-kernels.md says why.

template <class T>
void smooth_and_slope(const T* above, const T* here, const T* below, int64_t n, T* smooth, T* slope,
                      const T* next) {
  for_lanes_fetching<T>(n, next, [=](auto d, auto, int64_t k) {
    const auto a = hn::LoadU(d, above + k), c = hn::LoadU(d, below + k);
    hn::StoreU(hn::Add(hn::Add(a, hn::Mul(hn::Set(d, T(2)), hn::LoadU(d, here + k))), c), d, smooth + k);
    hn::StoreU(hn::Sub(c, a), d, slope + k);
  });
}

// Sobel's sums of the pixels at k.
template <class D, class T>
struct Sums {
  Sums(D d, const T* smooth, const T* slope, int64_t k)
      : x(hn::Sub(hn::LoadU(d, smooth + k + 1), hn::LoadU(d, smooth + k - 1))) {
    const auto twice = hn::Mul(hn::Set(d, T(2)), hn::LoadU(d, slope + k));
    y = hn::Add(hn::Add(hn::LoadU(d, slope + k - 1), twice), hn::LoadU(d, slope + k + 1));
  }
  hn::Vec<D> x, y;
};

template <class D>
HWY_INLINE hn::Vec<D> square_length(D d, hn::Vec<D> x, hn::Vec<D> y, hn::TFromD<D> eps) {
  return hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Set(d, eps));
}

template <class T>
void lengths(const T* smooth, const T* slope, int64_t n, T scale, T eps, T* out, const T* next) {
  for_lanes_fetching<T>(n, next, [=](auto d, auto, int64_t k) {
    const Sums<decltype(d), T> sums(d, smooth, slope, k);
    const auto factor = hn::Set(d, scale);
    hn::StoreU(hn::Sqrt(square_length(d, hn::Mul(sums.x, factor), hn::Mul(sums.y, factor), eps)), d, out + k);
  });
}

// Writes whole vectors, also at the end; the rows have room for them.
template <class T>
void magnitudes(const T* smooth, const T* slope, int64_t n, T eps, T* dx, T* dy, T* magnitude) {
  const Lanes<T> d;
  for (int64_t k = 0; k < n; k += kLanes<T>) {
    const Sums<Lanes<T>, T> sums(d, smooth, slope, k);
    hn::StoreU(sums.x, d, dx + k);
    hn::StoreU(sums.y, d, dy + k);
    hn::StoreU(hn::Sqrt(larger(square_length(d, sums.x, sums.y, eps), hn::Zero(d))), d, magnitude + k);
  }
}

// A ring of the gradients of three rows: the row that is thinned and its neighbours, with one more column at
// either end.
template <class T>
class Gradient {
 public:
  static constexpr int64_t kRows = 3 * 3 + 2;  // of scratch

  Gradient(const T* image, const Planes& planes, const Tile& tile, T eps, T* scratch, int64_t length)
      : image_(image),
        planes_(planes),
        height_(planes.height),
        width_(planes.width),
        tile_(tile),
        eps_(eps),
        length_(length),
        scratch_(scratch) {}

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
    smooth_and_slope(y > 0 ? here - width_ : here, here, y + 1 < height_ ? here + width_ : here, span.count(),
                     smooth + start, slope + start, tile_row(image_, planes_, tile_, y + 2));
    extend(smooth, tile_, width_, 2, 2, Border::kReplicate, T(0));
    extend(slope, tile_, width_, 2, 2, Border::kReplicate, T(0));
    magnitudes(smooth - 1, slope - 1, columns + 2, eps_, dx(y) - 1, dy(y) - 1, m - 1);
    if (tile_.left == 0) m[-1] = 0;
    if (tile_.right == width_) m[columns] = 0;
  }

 private:
  T* row(int64_t i) const { return scratch_ + i * length_ + 2; }

  const T* const image_;
  const Planes planes_;
  const int64_t height_, width_;
  const Tile tile_;
  const T eps_;
  const int64_t length_;
  T* const scratch_;
};

// The magnitude of each pixel that is a maximum along the gradient's direction, rounded to 45 degrees, else
// 0.
template <class T>
void thin(const T* above, const T* here, const T* below, const T* dx, const T* dy, int64_t n, T* out) {
  for_lanes<T>(n, [=](auto d, auto, int64_t k) {
    const auto at = [=](const T* values, int64_t shift) { return hn::LoadU(d, values + k + shift); };
    const auto centre = at(here, 0), x = at(dx, 0), y = at(dy, 0), zero = hn::Zero(d);
    const auto tangent = hn::Set(d, static_cast<T>(0.41421356237309503));  // tan(22.5 degrees)
    const auto wide = hn::Abs(x), high = hn::Abs(y);
    const auto horizontal = hn::Lt(high, hn::Mul(wide, tangent)),
               vertical = hn::Lt(wide, hn::Mul(high, tangent));
    // Of two equal adjacent pixels, the first is the ridge.
    const auto across = hn::And(hn::Gt(centre, at(here, -1)), hn::Ge(centre, at(here, 1)));
    const auto along = hn::And(hn::Gt(centre, at(above, 0)), hn::Ge(centre, at(below, 0)));
    const auto falling = hn::Gt(centre, larger(at(above, -1), at(below, 1)));
    const auto rising = hn::Gt(centre, larger(at(above, 1), at(below, -1)));
    const auto opposite = hn::Xor(hn::Gt(x, zero), hn::Gt(y, zero));
    const auto diagonal = hn::Or(hn::AndNot(opposite, falling), hn::And(opposite, rising));
    const auto straight = hn::Or(hn::And(horizontal, across), hn::And(vertical, along));
    hn::StoreU(
        hn::IfThenElseZero(hn::Or(straight, hn::AndNot(hn::Or(horizontal, vertical), diagonal)), centre), d,
        out + k);
  });
}

}  // namespace

template <class T>
void sobel(const T* x, Planes planes, T scale, T eps, T* out) {
  constexpr int64_t kLead = whole_lines<T>(1);
  for_tiles<T>(planes, 3 + 2 + 1, 2, kLead + 1, Border::kReplicate,
               [=](const Tile& tile, T* scratch, int64_t length) {
                 const int64_t plane = tile.plane * planes.height * planes.width;
                 const Span span(tile, planes.width, 1, 1);
                 const int64_t start = span.first - tile.left;
                 T *const smooth = scratch + kLead, *const slope = smooth + length;
                 for (int64_t y = tile.top; y < tile.bottom; ++y) {
                   const auto row = [&](int64_t i) { return tile_row(x + plane, planes, tile, i); };
                   T* const target = tile_row(out + plane, planes, tile, y);
                   smooth_and_slope(row(y - 1) + start, row(y) + start, row(y + 1) + start, span.count(),
                                    smooth + start, slope + start, target);
                   for (T* const values : {smooth, slope})
                     extend(values, tile, planes.width, 1, 1, Border::kReplicate, T(0));
                   lengths(smooth, slope, tile.right - tile.left, scale, eps, target, row(y + 2));
                 }
               });
}

template <class T>
void canny_nms(const T* x, Planes planes, T eps, T* out) {
  const int64_t height = planes.height, width = planes.width;
  for_tiles<T>(
      planes, Gradient<T>::kRows + 4, Gradient<T>::kRows, 4, Border::kReplicate,
      [=](const Tile& tile, T* scratch, int64_t length) {
        const Gradient<T> gradient(x + tile.plane * height * width, planes, tile, eps, scratch, length);
        gradient.compute(tile.top - 1);
        gradient.compute(tile.top);
        for (int64_t y = tile.top; y < tile.bottom; ++y) {
          gradient.compute(y + 1);
          thin(gradient.magnitude(y - 1), gradient.magnitude(y), gradient.magnitude(y + 1), gradient.dx(y),
               gradient.dy(y), tile.right - tile.left, out + (tile.plane * height + y) * width + tile.left);
        }
      });
}

CHIASM_INSTANTIATE(sobel)
CHIASM_INSTANTIATE(canny_nms)

}  // namespace chiasm::kernels
