// Reads images of 16 bits at positions: bilinearly from 2 x 2 pixels, or at the nearest ones. Positions are
// rounded to 1/65536, so that sums are exact in double.
#include <array>
#include <cmath>

#include "declared/warp_words.h"
#include "read_runs.h"
#include "words.h"

namespace chiasm::kernels {
namespace {

using namespace bytes;

constexpr int32_t kSteps = 65536;

template <class Word>
struct Bilinear : Places {
  // The weights of the second pixel, across and down.
  double right[kRun], below[kRun];

  static int64_t loaded(int64_t step) { return step == 1 ? 2 : step + 4; }

  void find(const double* at_x, const double* at_y, int64_t n, const Source& s) {
    find_along(at_x, n, s.width, s, x, right);
    find_along(at_y, n, s.height, s, y, below);
    // vectors of pixels have places of 32 bits, in bytes
    const int64_t limit = std::min<int64_t>((s.height - 1) * s.row() - s.wide + 1, 1 << 30);
    const Lanes<int32_t> d;
    for (int64_t i = 0; i < n; i += kLanes<int32_t>)
      put(i, hn::LoadU(d, x + i), hn::LoadU(d, y + i), s.width - 1, s.height - 1, limit, s);
  }

  template <int kStep>
  void read(const Word* image, const Source& s, int64_t n, const Word* fill, Word* out) const {
    for (int64_t i = 0; i < n;) {
      const int64_t last = end(i, n);
      if (inside[i]) {
        if constexpr (kStep == 1) i = read_plane(image, s.row(), i, last, out);
        if constexpr (kStep > 1) i = read_frame<kStep>(image, s.row(), i, last, out);
      }
      for (; i < last; ++i) read_one<kStep>(image, s, i, fill, out + i * s.step);
    }
  }

 private:
  // The first pixel to read along an axis, and the second one's weight. NaN is outside.
  static void find_along(const double* at, int64_t n, int64_t size, const Source& s, int32_t* first,
                         double* second) {
    const Lanes<double> d;
    const auto all = [=](double value) { return hn::Set(d, value); };
    const double last = static_cast<double>(size - 1);
    const bool reflects = s.padding == Padding::kReflection, edge = s.padding == Padding::kBorder;
    const double least = reflects ? -kFurthest
                         : edge   ? 0
                                  : -1,
                 greatest = reflects ? kFurthest
                            : edge   ? last
                                     : last + 1;
    for (int64_t i = 0; i < n; i += kLanes<double>) {
      const auto given = hn::LoadU(d, at + i);
      const auto limited = smaller(larger(given, all(least)), all(greatest));
      const auto known = hn::IfThenElse(hn::Eq(given, given), limited, all(-1));
      const auto steps = hn::Round(hn::Mul(known, all(kSteps)));
      auto place = hn::Mul(steps, all(1.0 / kSteps));
      if (reflects && !hn::AllTrue(d, hn::And(hn::Ge(place, all(0)), hn::Le(place, all(last))))) {
        double places[kLanes<double>];
        hn::StoreU(steps, d, places);
        for (int64_t k = 0; k < kLanes<double>; ++k)
          if (i + k < n && at[i + k] == at[i + k])
            places[k] =
                static_cast<double>(folded(static_cast<int64_t>(places[k]), size, kSteps, s.align_corners));
        place = hn::Mul(hn::LoadU(d, places), all(1.0 / kSteps));
      }
      const auto whole = hn::Floor(place);
      hn::StoreU(truncated(d, whole), Integers<Lanes<double>>(), first + i);
      hn::StoreU(hn::Sub(place, whole), d, second + i);
    }
  }

  // Any position.
  template <int kStep>
  void read_one(const Word* image, const Source& s, int64_t i, const Word* fill, Word* out) const {
    const int64_t step = kStep > 0 ? kStep : s.step;
    const auto beyond = [](int32_t first, double weight, int64_t size) {
      return first < -1 || first >= size || (first < 0 && weight == 0);
    };
    if (beyond(x[i], right[i], s.width) || beyond(y[i], below[i], s.height)) {
      std::copy_n(fill, step, out);
      return;
    }
    for (int64_t c = 0; c < step; ++c) {
      const auto pixel = [&](int64_t v, int64_t u) {
        const bool is_inside = v >= 0 && v < s.height && u >= 0 && u < s.width;
        return static_cast<double>(is_inside ? image[v * s.row() + u * step + c] : fill[c]);
      };
      const auto between = [](double a, double b, double weight) { return a + (b - a) * weight; };
      const auto across = [&](int64_t v) { return between(pixel(v, x[i]), pixel(v, x[i] + 1), right[i]); };
      out[c] = static_cast<Word>(std::floor(between(across(y[i]), across(y[i] + 1), below[i]) + 0.5));
    }
  }

  // Values between four pixels, rounded half up.
  template <class D>
  HWY_INLINE static hn::Vec<Integers<D>> between(D d, const std::array<hn::Vec<D>, 4>& pixels,
                                                 hn::Vec<D> right, hn::Vec<D> below) {
    const auto upper = hn::Add(pixels[0], hn::Mul(hn::Sub(pixels[1], pixels[0]), right)),
               lower = hn::Add(pixels[2], hn::Mul(hn::Sub(pixels[3], pixels[2]), right)),
               value = hn::Add(upper, hn::Mul(hn::Sub(lower, upper), below));
    return truncated(d, hn::Floor(hn::Add(value, hn::Set(d, 0.5))));
  }

  // Reads positions from i to last, whose pixels are inside; returns how many. Loads two pixels in one
  // integer.
  int64_t read_plane(const Word* image, int64_t row, int64_t i, int64_t last, Word* out) const {
    const Lanes<double> d;
    const Integers<decltype(d)> integers;
    const hn::Rebind<Word, decltype(d)> words;
    for (; i + kLanes<double> <= last; i += kLanes<double>) {
      const auto places = hn::ShiftLeft<1>(hn::LoadU(integers, index + i));
      std::array<hn::Vec<decltype(d)>, 4> pixels;
      for (size_t k = 0; k < 2; ++k) {
        const Word* const from = image + static_cast<int64_t>(k) * row;
        const auto both = hn::GatherOffset(integers, reinterpret_cast<const int32_t*>(from), places);
        pixels[2 * k] = hn::PromoteTo(d, low_half<Word>(integers, both));
        pixels[2 * k + 1] = hn::PromoteTo(d, high_half<Word>(integers, both));
      }
      const auto made = between(d, pixels, hn::LoadU(d, right + i), hn::LoadU(d, below + i));
      hn::StoreU(hn::DemoteTo(words, made), words, out + i);
    }
    return i;
  }

  // The same for pixels of kStep values. Loads and stores four; the next position overwrites an excess one.
  template <int kStep>
  int64_t read_frame(const Word* image, int64_t row, int64_t i, int64_t last, Word* out) const {
    const hn::CappedTag<double, 4> d;
    const hn::Rebind<Word, decltype(d)> words;
    constexpr auto kEach = static_cast<int64_t>(hn::MaxLanes(d));
    for (; i + (kStep == 3 ? 1 : 0) < last; ++i) {
      const Word* const from = image + index[i];
      for (int64_t c = 0; c < 4; c += kEach) {
        const std::array<hn::Vec<decltype(d)>, 4> pixels = {
            numbers_of(d, from + c), numbers_of(d, from + kStep + c), numbers_of(d, from + row + c),
            numbers_of(d, from + row + kStep + c)};
        const auto made = between(d, pixels, hn::Set(d, right[i]), hn::Set(d, below[i]));
        hn::StoreU(hn::DemoteTo(words, made), words, out + i * kStep + c);
      }
    }
    return i;
  }
};

template <class Word, class Positions>
void read_at(const Word* images, int64_t n, int64_t items, const Source& source, int64_t out_height,
             int64_t out_width, Interpolation mode, Fill<Word> fill, Word* out, const Positions& positions) {
  if (mode == Interpolation::kNearest)
    read_with<Nearest>(images, n, items, source, out_height, out_width, fill, out, positions);
  else
    read_with<Bilinear<Word>>(images, n, items, source, out_height, out_width, fill, out, positions);
}

}  // namespace

template <class S>
void remap_words(const S* image, int64_t n, int64_t height, int64_t width, const double* x, int64_t items,
                 int64_t out_height, int64_t out_width, const double* y, int64_t step, Interpolation mode,
                 Padding padding, bool align_corners, const S* fill, int64_t fills, S* out) {
  read_at(image, n, items, {height, width / step, step, 0, padding, align_corners}, out_height, out_width,
          mode, {fill, fills}, out, Given<double>{x, y, out_height, out_width});
}

template <class S>
void warp_words(const S* image, int64_t n, int64_t height, int64_t width, const double* matrix, int64_t items,
                int64_t out_height, int64_t out_width, int64_t step, Interpolation mode, Padding padding,
                bool align_corners, const S* fill, int64_t fills, S* out) {
  read_at(image, n, items, {height, width / step, step, 0, padding, align_corners}, out_height, out_width,
          mode, {fill, fills}, out, Mapped{matrix});
}

CHIASM_INSTANTIATE(remap_words)
CHIASM_INSTANTIATE(warp_words)

}  // namespace chiasm::kernels
