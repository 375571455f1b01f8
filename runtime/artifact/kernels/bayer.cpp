// Demosaicing: red, green and blue of Bayer images, whose pixels have one colour each.
#include "declared/bayer.h"
#include "interleaving.h"

namespace chiasm::kernels {
namespace {

// The mean of four integers, rounded half up, as the mean of the means of two pairs. It is reduced by one if
// the mean of a pair was rounded up and the last mean is too.
template <class D>
struct Means {
  hn::Vec<D> first, second, all;

  HWY_INLINE Means(D d, hn::Vec<D> a, hn::Vec<D> b, hn::Vec<D> c, hn::Vec<D> e)
      : first(hn::AverageRound(a, b)), second(hn::AverageRound(c, e)) {
    const auto rounded = hn::And(hn::Or(hn::Xor(a, b), hn::Xor(c, e)), hn::Xor(first, second));
    all = hn::Sub(hn::AverageRound(first, second), hn::And(rounded, hn::Set(d, hn::TFromD<D>{1})));
  }
};

// A row of pixels. Every other one, from the first or from the second on, has the row's own colour, red or
// blue; the others are green. `rows` also has the rows above and below, and one more pixel at either end.
template <bool kFromFirst, bool kRed, bool kInterleaved, class P>
void make_row(const P* const* rows, int64_t n, P* out, int64_t plane) {
  const Lanes<P> d;
  using V = hn::Vec<Lanes<P>>;
  for (int64_t k = 0; k < n; k += kLanes<P>) {
    const auto at = [&](int row, int64_t column) { return hn::LoadU(d, rows[row] + k + column); };
    const V here = at(1, 0);
    const Means<Lanes<P>> cross(d, at(1, -1), at(1, 1), at(0, 0), at(2, 0)),
        corners(d, at(0, -1), at(0, 1), at(2, -1), at(2, 1));
    const auto mixed = [](V own, V green) {
      return kFromFirst ? hn::OddEven(green, own) : hn::OddEven(own, green);
    };
    const V own = mixed(here, cross.first), other = mixed(corners.all, cross.second);
    const V colours[] = {kRed ? own : other, mixed(cross.all, here), kRed ? other : own};
    const auto store = [&](P* to, int64_t apart) {
      if constexpr (kInterleaved)
        store_pixels<3>(d, colours, to);
      else
        for (int64_t c = 0; c < 3; ++c) hn::StoreU(colours[c], d, to + c * apart);
    };
    if (k + kLanes<P> <= n) {
      store(out + (kInterleaved ? 3 : 1) * k, plane);
      continue;
    }
    P last[3 * kLanes<P>];
    store(last, kLanes<P>);
    if (kInterleaved)
      std::copy_n(last, 3 * (n - k), out + 3 * k);
    else
      for (int64_t c = 0; c < 3; ++c) std::copy_n(last + c * kLanes<P>, n - k, out + c * plane + k);
  }
}

}  // namespace

template <class U>
void demosaic(const U* x, int64_t n, int64_t height, int64_t width, int64_t red_row, int64_t red_column,
              bool interleaved, U* out) {
  const Planes planes{n, height, width};
  for_tiles<U>(
      planes, 8, 3, PaddedRows<U>::ends(planes, 3, 1), Border::kReflect,
      [&](const Tile& tile, U* ring, int64_t length) {
        const PaddedRows<U> rows(x + tile.plane * height * width, planes, tile, Border::kReflect, U{0}, 3, 3,
                                 1, 1, ring, length);
        for (int64_t y = tile.top; y < tile.bottom; ++y) {
          const bool red = y % 2 == red_row, from_first = red == (red_column == 0);
          const int64_t row = tile.plane * (interleaved ? 1 : 3) * height + y;
          U* const to = out + (interleaved ? 3 : 1) * (row * width + tile.left);
          rows.advance(y, to);
          const U* const around[] = {rows.at(y, 0, 1), rows.at(y, 1, 1), rows.at(y, 2, 1)};
          const auto make = [&](auto first, auto is_red) {
            (interleaved
                 ? make_row<decltype(first)::value, decltype(is_red)::value, true, U>
                 : make_row<decltype(first)::value, decltype(is_red)::value, false, U>)(around,
                                                                                        tile.right -
                                                                                            tile.left,
                                                                                        to, height * width);
          };
          const auto make_from = [&](auto first) {
            red ? make(first, std::true_type()) : make(first, std::false_type());
          };
          from_first ? make_from(std::true_type()) : make_from(std::false_type());
        }
      });
}

CHIASM_INSTANTIATE(demosaic)

}  // namespace chiasm::kernels
