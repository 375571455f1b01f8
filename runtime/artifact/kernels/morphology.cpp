// Maxima and minima of windows, row by row, at a cost that does not grow with the window's area.
//
// The loops over a row are functions of their own and take values, not references: a store of a vector may
// alias a variable behind a reference, which would be loaded again in every iteration.
#include <limits>
#include <utility>
#include <variant>

#include "declared/morphology.h"
#include "pixels.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

template <bool largest, class V>
HWY_INLINE V extreme(V a, V b) {
  return largest ? larger(a, b) : smaller(a, b);
}

// out[k] = the extreme of row[k] and row[k + shift], for k = 0 .. n - 1, in whole vectors; out may be row.
template <class T, bool largest>
void double_window(const T* row, int64_t shift, int64_t n, T* out) {
  const Lanes<T> d;
  for (int64_t k = 0; k < n; k += kLanes<T>)
    hn::StoreU(extreme<largest>(hn::LoadU(d, row + k), hn::LoadU(d, row + k + shift)), d, out + k);
}

// running[k] becomes the extreme of running[k] and x[k]; out[k] that of running[k] and out[k].
template <class T, bool largest>
void gather_row(const T* x, T* running, T* out, int64_t n, const T* next) {
  for_lanes_fetching<T>(n, next, [=](auto d, auto, int64_t k) {
    const auto value = extreme<largest>(hn::LoadU(d, running + k), hn::LoadU(d, x + k));
    hn::StoreU(value, d, running + k);
    hn::StoreU(extreme<largest>(hn::LoadU(d, out + k), value), d, out + k);
  });
}

template <class T>
struct Tap {
  int64_t row, column;
  T height;
};

// out[k] = the extreme of sources[t][k], plus the tap's height unless all are 0.
template <class T, bool largest, bool flat>
void extreme_of_taps(const T* const* sources, const Tap<T>* taps, int64_t count, int64_t n, T* out,
                     const T* next) {
  for_lanes_fetching<T, 4, true>(n, next, [=](auto d, auto vectors, int64_t k) {
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    const auto value = [=](int64_t t, int v) {
      const auto pixels = hn::LoadU(d, sources[t] + k + v * lanes);
      if constexpr (flat)
        return pixels;
      else
        return hn::Add(pixels, hn::Set(d, taps[t].height));
    };
    hn::Vec<decltype(d)> best[vectors];
    for (int v = 0; v < vectors; ++v) best[v] = value(0, v);
    for (int64_t t = 1; t < count; ++t)
      for (int v = 0; v < vectors; ++v) best[v] = extreme<largest>(best[v], value(t, v));
    for (int v = 0; v < vectors; ++v) hn::StoreU(best[v], d, out + k + v * lanes);
  });
}

// The same for so few rows that their addresses stay in registers.
template <class T, bool largest, int... kRows>
void extreme_of_few(const T* const* sources, std::integer_sequence<int, 0, kRows...>, int64_t n, T* out,
                    const T* next) {
  const T* const from[] = {sources[0], sources[kRows]...};
  for_lanes_fetching<T, 2, true>(n, next, [=](auto d, auto vectors, int64_t k) {
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    for (int v = 0; v < vectors; ++v) {
      auto best = hn::LoadU(d, from[0] + k + v * lanes);
      ((best = extreme<largest>(best, hn::LoadU(d, from[kRows] + k + v * lanes))), ...);
      hn::StoreU(best, d, out + k + v * lanes);
    }
  });
}

template <class T, bool largest>
void extreme_of_rows(const T* const* sources, int64_t count, int64_t n, T* out, const T* next) {
  const auto of = [&]<int kCount>(std::integral_constant<int, kCount>) {
    extreme_of_few<T, largest>(sources, std::make_integer_sequence<int, kCount>(), n, out, next);
  };
  switch (count) {
    case 2: return of(std::integral_constant<int, 2>());
    case 3: return of(std::integral_constant<int, 3>());
    case 4: return of(std::integral_constant<int, 4>());
    case 5: return of(std::integral_constant<int, 5>());
    default: return extreme_of_taps<T, largest, true>(sources, nullptr, count, n, out, next);
  }
}

// The neutral element of the extreme: every other value replaces it.
template <class T, bool largest>
constexpr T kLoser = largest ? (std::is_floating_point_v<T> ? -std::numeric_limits<T>::infinity()
                                                            : std::numeric_limits<T>::lowest())
                             : (std::is_floating_point_v<T> ? std::numeric_limits<T>::infinity()
                                                            : std::numeric_limits<T>::max());

// The image and border from which a tile's rows are computed.
template <class T>
struct Source {
  const T* image;
  const Planes& planes;
  const Tile& tile;
  Border border;
  T value;

  int64_t columns() const { return tile.right - tile.left; }
};

// A window without pixels.
template <class T, bool largest>
class NoRows {
 public:
  explicit NoRows(const Source<T>& source) : columns_(source.columns()) {}

  void row(int64_t, T* out) { std::fill_n(out, columns_, kLoser<T, largest>); }

 private:
  const int64_t columns_;
};

// A window of height x width pixels that begins (row, column) before its pixel.
struct Box {
  int64_t row, column, height, width;
  // Its reach to the left or to the right.
  int64_t reach() const { return std::max<int64_t>({column, width - 1 - column, 0}); }
};

/** Boxes: down the columns into a buffer, and from there along the row.
 *
 *  Tall ones by the method of M. van Herk, A fast algorithm for local minimum and maximum filters on
 *  rectangular and octagonal kernels, Pattern Recognition Letters 13(7), 1992, and J. Gil, M. Werman,
 *  Computing 2-D min, median, and max filters, IEEE TPAMI 15(5), 1993: for a group of as many rows as the box
 *  is tall, the extremes from each row to the group's last are kept; each one and the running extreme of the
 *  following rows make a window. Along the row by doubling the window's length, which allows loads of whole
 *  vectors at any position. */
template <class T, bool largest>
class BoxRows {
 public:
  // Up to this many rows, and shifts of a row, are compared at once.
  static constexpr int64_t kRows = 6, kShifts = 5;

  static int64_t scratch_rows(const Box& box) { return 1 + (box.height > kRows ? box.height + 1 : 1); }
  static int64_t lead(const Box& box, int64_t step) { return whole_lines<T>(box.reach() * step); }
  static int64_t ends(const Box& box, int64_t step) { return lead(box, step) + box.reach() * step; }
  static int64_t pointers() { return kRows + kShifts; }

  BoxRows(const Box& box, const Source<T>& source, T* scratch, int64_t length, const T** pointers)
      : box_(box),
        source_(source),
        margin_(box.reach() * source.planes.step),
        span_(source.tile, source.planes.width, margin_, margin_),
        constant_(scratch),
        lines_(scratch + length + lead(box, source.planes.step)),
        length_(length),
        pointers_(pointers) {
    std::fill_n(scratch, length, source.value);
  }

  void row(int64_t y, T* out) {
    T* const line = down(y, out);
    extend(line, source_.tile, source_.planes.width, margin_, margin_, source_.border, source_.value,
           source_.planes.step);
    along(line, out, tile_row(source_.image, source_.planes, source_.tile, y - box_.row + box_.height));
  }

 private:
  // Row y, which may be outside of the image, from the first column that the tile needs.
  const T* from(int64_t y) const {
    const int64_t row = inside(y, source_.planes.height, source_.border);
    return row < 0 ? constant_ : source_.image + row * source_.planes.width + span_.first;
  }

  // The extremes down the columns for the boxes of row y, in a line that the caller may overwrite.
  T* down(int64_t y, const T* next) {
    const int64_t start = span_.first - source_.tile.left, n = span_.count(), first = y - box_.row;
    if (box_.height <= kRows) {
      for (int64_t i = 0; i < box_.height; ++i) pointers_[i] = from(first + i);
      extreme_of_rows<T, largest>(pointers_, box_.height, n, lines_ + start, next);
      return lines_;
    }
    // Lines 1 .. height have the extremes from a row to the group's last; line 0 is the running one.
    const int64_t i = (y - source_.tile.top) % box_.height;
    const auto line = [&](int64_t k) { return lines_ + (k + 1) * length_ + start; };
    if (i == 0) {
      const T* last = from(first + box_.height - 1);
      pointers_[0] = last;
      extreme_of_rows<T, largest>(pointers_, 1, n, line(box_.height - 1), next);
      for (int64_t k = box_.height - 2; k >= 0; --k) {
        pointers_[0] = from(first + k), pointers_[1] = line(k + 1);
        extreme_of_rows<T, largest>(pointers_, 2, n, line(k), line(k));
      }
      // Start the running extreme with the neutral element.
      std::fill_n(line(-1), n, kLoser<T, largest>);
    } else {
      gather_row<T, largest>(from(first + box_.height - 1), line(-1), line(i), n, next);
    }
    return lines_ + (i + 1) * length_;
  }

  void along(T* line, T* out, const T* next) const {
    const int64_t step = source_.planes.step, columns = source_.columns();
    T* const first = line - box_.column * step;
    // Two windows of one length make a window of up to twice that length; they may overlap. Short windows are
    // faster without doubling, because a load that spans two recent stores must wait for them.
    int64_t size = 1;
    while (size * kShifts < box_.width) {
      double_window<T, largest>(first, size * step, columns + (box_.width - 2 * size) * step, first);
      size *= 2;
    }
    int64_t count = 0;
    for (int64_t j = 0; j < box_.width - size; j += size) pointers_[count++] = first + j * step;
    pointers_[count++] = first + (box_.width - size) * step;
    extreme_of_rows<T, largest>(pointers_, count, columns, out, next);
  }

  const Box box_;
  const Source<T> source_;
  const int64_t margin_;
  const Span span_;
  const T* const constant_;
  T* const lines_;
  const int64_t length_;
  const T** const pointers_;
};

/** Windows with few pixels, or with heights: each pixel of the window is compared. */
template <class T, bool largest>
class TapRows {
 public:
  TapRows(const std::vector<Tap<T>>& taps, bool flat, const Box& box, const Source<T>& source, T* scratch,
          int64_t length, const T** pointers)
      : taps_(taps),
        flat_(flat),
        columns_(source.columns()),
        rows_(source.image, source.planes, source.tile, source.border, source.value, box.height, box.width,
              box.row, box.column, scratch, length),
        pointers_(pointers) {}

  void row(int64_t y, T* out) {
    const T* const next = rows_.advance(y, out);
    const auto count = static_cast<int64_t>(taps_.size());
    for (int64_t t = 0; t < count; ++t)
      pointers_[t] = rows_.at(y, taps_[static_cast<size_t>(t)].row, taps_[static_cast<size_t>(t)].column);
    if (flat_)
      extreme_of_rows<T, largest>(pointers_, count, columns_, out, next);
    else
      extreme_of_taps<T, largest, false>(pointers_, taps_.data(), count, columns_, out, next);
  }

 private:
  const std::vector<Tap<T>>& taps_;
  const bool flat_;
  const int64_t columns_;
  const PaddedRows<T> rows_;
  const T** const pointers_;
};

// Adjacent pixels in a row of a window. At the end, `length` is an index into the list of lengths.
struct Chord {
  int64_t row, column, length;
};

/** Flat windows of any shape, as the chords that their rows are made of: E. Urbach, M. Wilkinson, Efficient
 *  2-D grayscale morphological transformations with arbitrary flat structuring elements, IEEE TIP 17(1),
 *  2008. For each row of the image the extremes of every chord length are computed once, each from a shorter
 *  length, and kept for as many rows as the window has. */
template <class T, bool largest>
class ChordRows {
 public:
  ChordRows(const std::vector<Chord>& chords, const std::vector<int64_t>& lengths, const Box& box,
            const Source<T>& source, T* scratch, int64_t length, const T** pointers)
      : chords_(chords),
        lengths_(lengths),
        box_(box),
        step_(source.planes.step),
        columns_(source.columns()),
        rows_(source.image, source.planes, source.tile, source.border, source.value, box.height, box.width,
              box.row, box.column, scratch, length),
        rings_(scratch + box.height * length),
        row_length_(length),
        pointers_(pointers) {
    for (int64_t i = 0; i + 1 < box.height; ++i) lengthen(source.tile.top, i);
  }

  void row(int64_t y, T* out) {
    const T* const next = rows_.advance(y, out);
    lengthen(y, box_.height - 1);
    int64_t count = 0;
    for (const Chord& c : chords_)
      pointers_[count++] = c.length == 0 ? rows_.at(y, c.row, c.column)
                                         : place(y - box_.row + c.row, c.length) + c.column * step_;
    extreme_of_rows<T, largest>(pointers_, count, columns_, out, next);
  }

 private:
  T* place(int64_t y, int64_t length) const {
    return rings_ + ((length - 1) * box_.height + (y + box_.height) % box_.height) * row_length_;
  }

  // Computes the extremes of all lengths for row i of the windows of row y.
  void lengthen(int64_t y, int64_t i) {
    const T* shorter = rows_.at(y, i, 0);
    for (size_t k = 1; k < lengths_.size(); ++k) {
      T* const longer = place(y - box_.row + i, static_cast<int64_t>(k));
      double_window<T, largest>(shorter, (lengths_[k] - lengths_[k - 1]) * step_,
                                columns_ + (box_.width - lengths_[k]) * step_, longer);
      shorter = longer;
    }
  }

  const std::vector<Chord>& chords_;
  const std::vector<int64_t>& lengths_;
  const Box box_;
  const int64_t step_, columns_;
  const PaddedRows<T> rows_;
  T* const rings_;
  const int64_t row_length_;
  const T** const pointers_;
};

/** A window, and the fastest method for its rows. */
template <class T, bool largest>
class Window {
 public:
  using Rows =
      std::variant<NoRows<T, largest>, BoxRows<T, largest>, TapRows<T, largest>, ChordRows<T, largest>>;

  explicit Window(const Box& box) : box_(box) {}

  // The pixels of a window of kh x kw and the heights that are added to them. A pixel with the height
  // -max_val is outside of the window. Integers have no other heights, and such a pixel is skipped. With
  // floats it is skipped only if the origin is in the window: the origin always has a pixel of the image,
  // which replaces the neutral element.
  Window(const double* heights, int64_t kh, int64_t kw, int64_t row, int64_t column, double max_val)
      : box_{row, column, kh, kw} {
    const auto height = [=](int64_t k) { return static_cast<T>(heights[k]); };
    constexpr bool whole = std::is_integral_v<T>;
    const auto none = [=](int64_t k) {
      return whole ? heights[k] == -max_val : height(k) == -static_cast<T>(max_val);
    };
    const bool anchored = whole || !none(row * kw + column);
    for (int64_t i = 0; i < kh; ++i)
      for (int64_t j = 0; j < kw; ++j) {
        const int64_t k = i * kw + j;
        if (anchored && none(k)) continue;
        const T added = whole ? T(0) : largest ? height(k) : static_cast<T>(-height(k));
        taps_.push_back({i, j, added});
        flat_ = flat_ && added == 0;
      }
    if (flat_) simplify();
  }

  // The rows of scratch, and the number of pointers, that a tile needs.
  int64_t scratch_rows() const {
    if (taps_.empty()) return BoxRows<T, largest>::scratch_rows(box_);
    return box_.height * std::max<int64_t>(1, static_cast<int64_t>(lengths_.size()));
  }
  int64_t pointers() const {
    return std::max<int64_t>(BoxRows<T, largest>::pointers(), static_cast<int64_t>(taps_.size()));
  }
  int64_t ends(const Planes& planes) const {
    return std::max(BoxRows<T, largest>::ends(box_, planes.step),
                    PaddedRows<T>::ends(planes, box_.width, box_.column));
  }
  // Tiles are so tall that few rows around them are read twice, and hold whole groups of a box's rows.
  int64_t tile_rows() const {
    const int64_t rows = std::max(kTileRows, 4 * box_.height);
    return box_.height > 0 ? (rows + box_.height - 1) / box_.height * box_.height : rows;
  }

  Rows rows(const Source<T>& source, T* scratch, int64_t length, const T** pointers) const {
    if (box_.height == 0) return NoRows<T, largest>(source);
    if (taps_.empty()) return BoxRows<T, largest>(box_, source, scratch, length, pointers);
    if (lengths_.empty()) return TapRows<T, largest>(taps_, flat_, box_, source, scratch, length, pointers);
    return ChordRows<T, largest>(chords_, lengths_, box_, source, scratch, length, pointers);
  }

 private:
  // Windows of up to this many pixels are computed pixel by pixel.
  static constexpr size_t kFew = 9;

  // A flat window may be a box, or consist of chords.
  void simplify() {
    if (taps_.empty()) {
      box_ = {0, 0, 0, 0};
      return;
    }
    int64_t left = box_.width, right = 0;
    for (const Tap<T>& t : taps_) left = std::min(left, t.column), right = std::max(right, t.column + 1);
    const int64_t top = taps_.front().row, bottom = taps_.back().row + 1;
    if (static_cast<int64_t>(taps_.size()) == (right - left) * (bottom - top)) {
      box_ = {box_.row - top, box_.column - left, bottom - top, right - left};
      taps_.clear();
      return;
    }
    if (taps_.size() > kFew) find_chords();
  }

  void find_chords() {
    for (const Tap<T>& t : taps_) {
      if (!chords_.empty() && chords_.back().row == t.row &&
          chords_.back().column + chords_.back().length == t.column)
        ++chords_.back().length;
      else
        chords_.push_back({t.row, t.column, 1});
    }
    std::vector<int64_t> needed;
    for (const Chord& c : chords_) needed.push_back(c.length);
    std::sort(needed.begin(), needed.end());
    lengths_ = {1};
    for (const int64_t n : needed) {
      while (2 * lengths_.back() < n) lengths_.push_back(2 * lengths_.back());
      if (n > lengths_.back()) lengths_.push_back(n);
    }
    for (Chord& c : chords_)
      c.length = std::lower_bound(lengths_.begin(), lengths_.end(), c.length) - lengths_.begin();
  }

  Box box_;
  bool flat_ = true;
  std::vector<Tap<T>> taps_;
  std::vector<Chord> chords_;
  std::vector<int64_t> lengths_;
};

// Fills the rows of all planes by one window.
template <class T, bool largest>
void filter(const T* x, const Planes& planes, const Window<T, largest>& window, Border border, T value,
            T* out) {
  std::vector<const T*> all_pointers(static_cast<size_t>(window.pointers() * omp_get_max_threads()));
  const int64_t rows = window.scratch_rows();
  for_tiles<T>(
      planes, rows + 2, rows, window.ends(planes), border,
      [&](const Tile& tile, T* scratch, int64_t length) {
        const int64_t plane = tile.plane * planes.height * planes.width;
        auto of = window.rows({x + plane, planes, tile, border, value}, scratch, length,
                              all_pointers.data() + window.pointers() * omp_get_thread_num());
        std::visit(
            [&](auto& made) {
              for (int64_t y = tile.top; y < tile.bottom; ++y)
                made.row(y, tile_row(out + plane, planes, tile, y));
            },
            of);
      },
      window.tile_rows());
}

// high[k] -= low[k]; integers saturate.
template <class T>
void subtract(T* high, const T* low, int64_t n) {
  for_lanes<T>(n, [=](auto d, auto, int64_t k) {
    const auto a = hn::LoadU(d, high + k), b = hn::LoadU(d, low + k);
    if constexpr (std::is_floating_point_v<T>)
      hn::StoreU(hn::Sub(a, b), d, high + k);
    else
      hn::StoreU(hn::SaturatedSub(a, b), d, high + k);
  });
}

}  // namespace

template <class P>
void minmax_filter(const P* x, int64_t n, int64_t h, int64_t l, int64_t step, int64_t ky, int64_t kx,
                   Border border, double value, bool largest, P* out) {
  // A window that reaches further than the image is large has nothing more to compare: the memory would grow.
  ky = std::min(ky, 2 * h + 1);
  kx = std::min(kx, 2 * (l / step) + 1);
  const Box box{ky / 2, kx / 2, ky, kx};
  const Planes planes{n, h, l, step};
  if (largest)
    filter(x, planes, Window<P, true>(box), border, as_pixel<P>(value), out);
  else
    filter(x, planes, Window<P, false>(box), border, as_pixel<P>(value), out);
}

template <class P>
void morphology(const P* x, int64_t n, int64_t h, int64_t l, int64_t step, const double* heights, int64_t kh,
                int64_t kw, int64_t row, int64_t column, Border border, double value, double max_val,
                bool largest, P* out) {
  const Planes planes{n, h, l, step};
  if (largest)
    filter(x, planes, Window<P, true>(heights, kh, kw, row, column, max_val), border, as_pixel<P>(value),
           out);
  else
    filter(x, planes, Window<P, false>(heights, kh, kw, row, column, max_val), border, as_pixel<P>(value),
           out);
}

template <class P>
void morphology_gradient(const P* x, int64_t n, int64_t h, int64_t l, int64_t step,
                         const double* dilation_heights, int64_t kh, int64_t kw,
                         const double* erosion_heights, int64_t row, int64_t column, Border border,
                         double dilation_value, double erosion_value, double max_val, P* out) {
  const Planes planes{n, h, l, step};
  const Window<P, true> high(dilation_heights, kh, kw, row, column, max_val);
  const Window<P, false> low(erosion_heights, kh, kw, row, column, max_val);
  const int64_t pointers = high.pointers() + low.pointers();
  std::vector<const P*> all_pointers(static_cast<size_t>(pointers * omp_get_max_threads()));
  const int64_t rows = high.scratch_rows() + low.scratch_rows() + 1;
  for_tiles<P>(
      planes, rows + 2, rows, std::max(high.ends(planes), low.ends(planes)), border,
      [&](const Tile& tile, P* scratch, int64_t length) {
        const int64_t plane = tile.plane * planes.height * planes.width;
        const P** const own = all_pointers.data() + pointers * omp_get_thread_num();
        P *const low_scratch = scratch + high.scratch_rows() * length, *const line =
                                                                           low_scratch +
                                                                           low.scratch_rows() * length;
        auto high_rows =
            high.rows({x + plane, planes, tile, border, as_pixel<P>(dilation_value)}, scratch, length, own);
        auto low_rows = low.rows({x + plane, planes, tile, border, as_pixel<P>(erosion_value)}, low_scratch,
                                 length, own + high.pointers());
        for (int64_t y = tile.top; y < tile.bottom; ++y) {
          P* const target = tile_row(out + plane, planes, tile, y);
          std::visit([&](auto& made) { made.row(y, target); }, high_rows);
          std::visit([&](auto& made) { made.row(y, line); }, low_rows);
          subtract(target, line, tile.right - tile.left);
        }
      },
      high.tile_rows());
}

CHIASM_INSTANTIATE(minmax_filter)
CHIASM_INSTANTIATE(morphology)
CHIASM_INSTANTIATE(morphology_gradient)

}  // namespace chiasm::kernels
