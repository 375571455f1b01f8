// Maxima and means of the pixels, and means of points between pixels, in the bins of boxes.
#include <limits>

#include "declared/regions.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// The bins of boxes: rows from top to bottom and columns from left to right, without the last.
struct Bins {
  int64_t rows, columns;
  const int64_t *image, *top, *bottom, *left, *right;
};

// out = value(plane of the bin, its corners), for every box, channel and bin. Numbers outside the images are
// limited.
template <class T, class Plane, class Value>
void over_bins(const Images& images, int64_t boxes, const Bins& bins, const Plane& plane, const Value& value,
               T* out) {
  if (images.count == 0) {
    std::fill_n(out, boxes * images.channels * bins.rows * bins.columns, T(0));
    return;
  }
#pragma omp parallel for
  for (int64_t i = 0; i < boxes * images.channels; ++i) {
    const int64_t box = i / images.channels, channel = i % images.channels;
    const int64_t image = std::clamp<int64_t>(bins.image[box], 0, images.count - 1);
    for (int64_t row = 0; row < bins.rows; ++row)
      for (int64_t column = 0; column < bins.columns; ++column) {
        const int64_t y = box * bins.rows + row, x = box * bins.columns + column;
        out[(i * bins.rows + row) * bins.columns + column] =
            value(plane(image, channel, row * bins.columns + column),
                  std::clamp<int64_t>(bins.top[y], 0, images.height),
                  std::clamp<int64_t>(bins.bottom[y], 0, images.height),
                  std::clamp<int64_t>(bins.left[x], 0, images.width),
                  std::clamp<int64_t>(bins.right[x], 0, images.width));
      }
  }
}

// A position along an axis: its two pixels, and their weights.
template <class T>
struct Tap {
  int64_t near, far;
  T of_near, of_far;
};

template <class T>
Tap<T> tap(T position, int64_t size) {
  const bool inside = position >= T(-1) && position <= static_cast<T>(size);
  const T at = position == position ? std::clamp(position, T(0), static_cast<T>(size - 1)) : T(0);
  const int64_t near = std::min(static_cast<int64_t>(at), size - 1);  // T may round size - 1 up
  const T part = at - static_cast<T>(near);
  return {near, std::min(near + 1, size - 1), inside ? 1 - part : T(0), inside ? part : T(0)};
}

}  // namespace

template <class T>
void box_maxima(const T* x, Images images, const int64_t* image, int64_t boxes, const int64_t* top,
                int64_t rows, const int64_t* bottom, const int64_t* left, int64_t columns,
                const int64_t* right, T* out) {
  const int64_t area = images.height * images.width, width = images.width;
  over_bins(
      images, boxes, Bins{rows, columns, image, top, bottom, left, right},
      [=](int64_t item, int64_t channel, int64_t) { return x + (item * images.channels + channel) * area; },
      [=](const T* plane, int64_t first_row, int64_t last_row, int64_t first, int64_t last) {
        if (first_row >= last_row || first >= last) return T(0);
        T most = -std::numeric_limits<T>::infinity();
        for (int64_t row = first_row; row < last_row; ++row)
          for (int64_t k = first; k < last; ++k) {
            const T value = plane[row * width + k];
            if (value > most || value != value) most = value;  // NaN stays
          }
        return most;
      },
      out);
}

template <class T>
void box_means(const T* x, int64_t count, int64_t channels, int64_t planes, int64_t height, int64_t width,
               const int64_t* image, int64_t boxes, const int64_t* top, int64_t rows, const int64_t* bottom,
               const int64_t* left, int64_t columns, const int64_t* right, T* out) {
  over_bins(
      Images{count, channels, height, width}, boxes, Bins{rows, columns, image, top, bottom, left, right},
      [=](int64_t item, int64_t channel, int64_t bin) {
        return x + ((item * channels + channel) * planes + bin) * height * width;
      },
      [=](const T* plane, int64_t first_row, int64_t last_row, int64_t first, int64_t last) {
        if (first_row >= last_row || first >= last) return T(0);
        double sum = 0;
        for (int64_t row = first_row; row < last_row; ++row)
          for (int64_t k = first; k < last; ++k) sum += static_cast<double>(plane[row * width + k]);
        return static_cast<T>(sum / static_cast<double>((last_row - first_row) * (last - first)));
      },
      out);
}

template <class T>
void bilinear_means(const T* x, int64_t count, int64_t channels, int64_t planes, int64_t height,
                    int64_t width, const int64_t* image, int64_t boxes, const T* rows, int64_t bin_rows,
                    int64_t points_y, const T* columns, int64_t bin_columns, int64_t points_x, int64_t shared,
                    T* out) {
  const int64_t tall = bin_rows * points_y, wide = bin_columns * points_x, area = height * width;
  if (count == 0) {
    std::fill_n(out, boxes * channels * bin_rows * bin_columns, T(0));
    return;
  }
  std::vector<Tap<T>> down(static_cast<size_t>(boxes * tall)), across(static_cast<size_t>(boxes * wide));
  for (size_t i = 0; i < down.size(); ++i) down[i] = tap(rows[i], height);
  for (size_t i = 0; i < across.size(); ++i) across[i] = tap(columns[i], width);
#pragma omp parallel for
  for (int64_t i = 0; i < boxes * channels; ++i) {
    const int64_t box = i / channels, item = std::clamp<int64_t>(image[box], 0, count - 1);
    const T* const channel = x + (item * channels + i % channels) * planes * area;
    for (int64_t bin = 0; bin < bin_rows * bin_columns; ++bin) {
      const T* const plane = channel + bin / shared * area;
      const Tap<T>* const y = down.data() + box * tall + bin / bin_columns * points_y;
      const Tap<T>* const h = across.data() + box * wide + bin % bin_columns * points_x;
      T sum = 0;
      for (int64_t j = 0; j < points_y; ++j) {
        const T *const upper = plane + y[j].near * width, *const lower = plane + y[j].far * width;
        T of_row = 0;
        for (int64_t k = 0; k < points_x; ++k)
          of_row += y[j].of_near * (h[k].of_near * upper[h[k].near] + h[k].of_far * upper[h[k].far]) +
                    y[j].of_far * (h[k].of_near * lower[h[k].near] + h[k].of_far * lower[h[k].far]);
        sum += of_row / static_cast<T>(points_x);
      }
      out[i * bin_rows * bin_columns + bin] = sum / static_cast<T>(points_y);
    }
  }
}

CHIASM_INSTANTIATE(box_maxima)
CHIASM_INSTANTIATE(bilinear_means)
CHIASM_INSTANTIATE(box_means)

}  // namespace chiasm::kernels
