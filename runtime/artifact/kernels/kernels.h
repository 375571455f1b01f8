/** Loops that tensor code cannot reach: chiasm's kernels for the CPU, on plain pointers.
 *
 *  Each does the work of a function in python/chiasm/primitives/kernels.py, whose tensor form defines it; compiled ops call it in the
 *  tensor form's place. Tensors are dense and row-major. T is float or double where there is a T. They need the instruction set that
 *  they are compiled for (lanes.h), and may throw std::bad_alloc. They share the work among the threads of the run that they belong to.
 */
#pragma once

#include <cstdint>
#include <vector>

namespace chiasm::kernels {

/** What is seen beyond an image; in the order of their names in kernels.py. */
enum class Border : int64_t { kReflect, kReplicate, kCircular, kConstant };

struct Planes {
  int64_t count, height, width;
};

struct Images {
  int64_t count, channels, height, width;
};

/** How positions between pixels are read, and what is seen beyond an image; in the order of their names in kernels.py. */
enum class Interpolation : int64_t { kBilinear, kNearest };
enum class Padding : int64_t { kZeros, kBorder, kReflection };

/** scale * (correlation down the columns and then along the rows) + centre * x. `taps_y` has ky weights for each `planes_per_row` planes, or, where that is 0,
 *  for all; `taps_x` likewise. Sizes are odd; a constant border is 0. */
template <class T>
void separable(const T* x, Planes planes, const T* taps_y, int64_t ky, int64_t planes_per_row_y, const T* taps_x, int64_t kx,
               int64_t planes_per_row_x, Border border, T scale, T centre, T* out);

/** Correlation with kernels of kh x kw for each `planes_per_kernel` planes, or, where that is 0, one for all; of an even size the pixel is the one before the
 *  middle. A constant border is 0. */
template <class T>
void correlate2d(const T* x, Planes planes, const T* kernels, int64_t kh, int64_t kw, int64_t planes_per_kernel, Border border, T* out);

/** The largest or smallest value of a centred window of ky x kx pixels, both odd. */
template <class T>
void rectangle_extreme(const T* x, Planes planes, int64_t ky, int64_t kx, Border border, T value, bool largest, T* out);

/** The largest x + height or smallest x - height over a window of kh x kw that begins (row, column) before the pixel. `heights` are in
 *  the window's order; -absent stands for a pixel that the window leaves out. */
template <class T>
void structured_extreme(const T* x, Planes planes, const T* heights, int64_t kh, int64_t kw, int64_t row, int64_t column, Border border,
                        T value, T absent, bool largest, T* out);

/** The largest x + height minus the smallest x - height: a morphological gradient. Each extreme has its own window and value beyond the
 *  image. */
template <class T>
void structured_range(const T* x, Planes planes, const T* high_window, const T* low_window, int64_t kh, int64_t kw, int64_t row, int64_t column,
                      Border border, T high_value, T low_value, T absent, T* out);

/** The median of 3 x 3 pixels. */
template <class T>
void median3x3(const T* x, Planes planes, Border border, T* out);

/** Sums over all that is above and to the left, rounded to T along the rows and then along the columns. */
template <class T>
void integral(const T* x, Planes planes, T* out);

/** The luma of ITU-R BT.601, in [0, 255], of n pixels that are bytes B, G, R. */
void frame_to_grey(const uint8_t* frame, int64_t n, float* out);

/** The planes R, G, B, in [0, 255], of a frame of such pixels, bilinearly resized; it is two pixels wide or more. */
void resize_frame(const uint8_t* frame, int64_t height, int64_t width, int64_t new_height, int64_t new_width, float* out);

/** The nearest of 256 levels of each of n values in [0, 1], halves up; what is outside counts as 0 or 1, NaN as 0. */
template <class T>
void to_levels(const T* x, int64_t n, uint8_t* levels);

/** The least and the greatest of each row's n values, `rows` least ones first; NaN where a row has NaN. */
template <class T>
void extents(const T* x, int64_t rows, int64_t n, T* out);

/** counts[row][i]: how many of a row's n values are in bin i = floor((value - low[row]) / span[row] * bins), the first bin at least, also for NaN, and the last at
 *  most; of 2^24 bins at most. */
template <class T>
void bin_counts(const T* x, const T* low, const T* span, int64_t rows, int64_t n, int64_t bins, int32_t* counts);

/** counts[row][i]: how often i, 0 <= i < bins, occurs among the n numbers of a row. */
template <class Index>
void count_each(const Index* index, int64_t rows, int64_t n, int64_t bins, int32_t* counts);

/** out[row][i] = table[row][index[row][i]]; the table's rows have 256 entries. */
template <class T>
void look_up(const T* table, const uint8_t* index, int64_t rows, int64_t n, T* out);

/** How often each of 256 levels occurs in each of the tiles_y x tiles_x tiles, tile_y x tile_x pixels each, of planes that are mirrored at
 *  their bottom and right ends. */
void tile_counts(const uint8_t* levels, Planes planes, int64_t tile_y, int64_t tile_x, int64_t tiles_y, int64_t tiles_x, int32_t* counts);

/** Bilinear blend of the curves of four tiles: `table` has 256 entries for each tile of each plane, and position y of an axis takes tiles
 *  first_y[y] and second_y[y], the second with weight weight_y[y]. Rounded to even. */
void blend_curves(const float* table, int64_t tiles, int64_t tiles_x, const uint8_t* levels, Planes planes, const int64_t* first_y,
                  const int64_t* second_y, const float* weight_y, const int64_t* first_x, const int64_t* second_x, const float* weight_x,
                  uint8_t* out);

/** The lowest flat index in the 8-connected component of each pixel of `mask`; of other pixels their own. */
void component_roots(const bool* mask, Planes planes, int32_t* roots);

/** Bilateral filtering of `images` with `channels` planes each, by the colours of as many guides (or one shared by all) with `depth`
 *  planes. A neighbour's weight is exp(falloff * distance^2) * nearness; the distance sums absolute differences, or with `squares` is
 *  Euclidean. `nearness` is ky x kx and the same on opposite sides. What is not shared is there for each image. A constant border is 0. */
template <class T>
void bilateral(const T* x, int64_t channels, const T* guide, int64_t depth, bool shared_guide, Planes images, const T* nearness, bool shared_nearness,
               int64_t ky, int64_t kx, const T* falloff, bool shared_falloff, Border border, bool squares, T* out);

/** The magnitude sqrt(dx^2 + dy^2 + eps) of `scale` times the Sobel gradient, the border replicated. */
template <class T>
void sobel(const T* x, Planes planes, T scale, T eps, T* out);

/** Canny's ridges: the magnitude sqrt(dx^2 + dy^2 + eps) of the Sobel gradient, the border replicated, where it is a maximum across the
 *  edge, and 0 elsewhere. */
template <class T>
void ridges(const T* x, Planes planes, T eps, T* out);

/** Which values above `low` are 8-connected through such to one above `high`. */
template <class T>
void hysteresis(const T* x, Planes planes, T low, T high, bool* out);

/** Each image at the pixel positions x and y of its own out_height x out_width. `corners`: reflection is about the corner pixels' centres, else
 *  about the outer edges. */
template <class T>
void sample(const T* source, Images images, const T* x, const T* y, int64_t out_height, int64_t out_width, Interpolation mode, Padding padding,
            bool corners, T* out);

/** `sample` where an image's 3 x 3 matrix leads, from the pixels of the output. */
template <class T>
void sample_projective(const T* source, Images images, const T* matrices, int64_t out_height, int64_t out_width, Interpolation mode, Padding padding,
                       bool corners, T* out);

/** Between which pixels resizing interpolates; in the order of their names in kernels.py. */
enum class Filter : int64_t { kNearest, kBilinear, kBicubic };

/** Along an axis each of `count` pixels is the sum of `each` pixels, index[i * each + k], by weights. */
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

/** Those of `out` pixels that `in` pixels are resized to. With `corners` the centres of the first and last pixels coincide, else their outer
 *  edges; with `antialias` a filter that reduces is as wide as the reduction. */
template <class T>
Taps<T> resize_taps(int64_t in, int64_t out, Filter filter, bool corners, bool antialias);

/** Those of an image of `size` pixels that stand for `taps` of what a kernel of odd length makes of it. */
template <class T>
Taps<T> blurred_before(const Taps<T>& taps, const std::vector<T>& kernel, Border border, int64_t size);

/** Those that stand for what a kernel of odd length makes of the result of `taps`. */
template <class T>
Taps<T> blurred_after(const Taps<T>& taps, const std::vector<T>& kernel, Border border);

/** Pixel (y, x) of the output is the sum of what `down` has for y and `across` for x. Pixels with a weight of 0 are not read. */
template <class T>
void resample(const T* x, Planes planes, const Taps<T>& down, const Taps<T>& across, T* out);

/** Most rows of the matrices that the next three take; `planes` are n x n. */
constexpr int64_t kMostRows = 16;

/** Inverses by Gauss-Jordan elimination with the largest pivot of each column; infinite or not a number where a matrix is singular. */
void gauss_jordan(const double* m, Planes planes, double* out);

/** Inverses of symmetric positive definite matrices, by n sweeps. */
void spd_inverse(const double* m, Planes planes, double* out);

/** Each matrix divided by its trace and squared, so many times. */
void high_power(const double* m, Planes planes, int64_t squarings, double* out);

constexpr int64_t kMostDegree = 16;

/** Real roots of `count` polynomials with coefficients[k][i] of x^k, k <= degree <= kMostDegree: the root is u / (1 - |u|) of places[k][i], ascending, where
 *  exist[k][i] is 1. Where it is 0, the place is that of a root of the derivative, or the end of the range. */
void real_roots(const double* coefficients, int64_t degree, int64_t count, double* places, double* exist);

/** Of each item's `per_item` 3 x 3 models the `count` with the least costs, of equals the first; 0 where fewer have a finite cost. A cost is the
 *  sum of the squared distances in the second image, or with `epipolar` of Sampson's, each at most its bound. `planes` are an item's n
 *  points: x, y, 1, then u, v, 1, then the bound. */
template <class T>
void cheapest_models(const T* models, const T* planes, int64_t batch, int64_t per_item, int64_t n, bool epipolar, int64_t count, int64_t* out);

/** Patches of side x side pixels: pixel (i, j) is read, bilinearly and beyond the border the last pixel, where a frame's 2 x 3 matrix leads from
 *  ((2 j + 1) / side - 1, (2 i + 1) / side - 1). Each row of pixels holds several images; each frame's begins at `start` and has `height` x `width`
 *  pixels. `rows.height` x `rows.width` is a row's length. */
template <class T>
void sample_patches(const T* pixels, Images rows, const int64_t* start, const int64_t* height, const int64_t* width, const T* frames, int64_t frames_per_row,
                    int64_t side, T* out);

/** Of each volume of `channels` planes the `count` strongest places that exceed their 26 neighbours and 0, or with `minima` fall below them and 0, and
 *  lie at least margins[plane] pixels from the plane's border: indices in the volume by descending magnitude, of equals the first; -1 where there are
 *  no more. */
template <class T>
void strongest_extrema(const T* x, Images volumes, const int64_t* margins, bool minima, int64_t count, int64_t* out);

/** Squared Euclidean distances of `rows` vectors of `depth` entries from `columns` such, of each item, as differences in double of squared lengths and
 *  products. */
template <class T>
void squared_distances(const T* a, const T* b, int64_t batch, int64_t rows, int64_t columns, int64_t depth, T* out);

/** Where the least and the second least number along each row, or column, is: pairs of indices, of equals the first; -1 where there is none that is
 *  less than infinity. */
template <class T>
void two_least(const T* x, Planes planes, bool along_rows, int64_t* out);

/** Histograms (count, bins, places, places) of the directions of square patches' central differences, the border replicated: lengths times `window`, shared
 *  linearly by the two nearest of `bins` directions, and by nearness (places x size) along rows and along columns. */
template <class T>
void direction_histograms(const T* patches, int64_t count, int64_t size, const T* window, const T* nearness, int64_t places, int64_t bins, T* out);

}  // namespace chiasm::kernels
