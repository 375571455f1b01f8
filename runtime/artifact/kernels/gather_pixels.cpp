// Images of the pixels in some rows and columns.
#include "declared/gather_pixels.h"

#include <cstring>

#include "pixels.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// Neighbours in a row of the result that are neighbours in the image too, or that are none of its pixels:
// then `from` is -1.
struct Run {
  int64_t to, from, pixels;
};

std::vector<Run> runs_of(const int32_t* columns, int64_t count, int64_t width) {
  std::vector<Run> runs;
  for (int64_t i = 0; i < count; ++i) {
    const int64_t from = columns[i] >= 0 && columns[i] < width ? columns[i] : -1;
    if (!runs.empty()) {
      Run& last = runs.back();
      if (last.from < 0 ? from < 0 : from == last.from + last.pixels) {
        ++last.pixels;
        continue;
      }
    }
    runs.push_back({i, from, 1});
  }
  return runs;
}

}  // namespace

template <class P>
void gather_pixels(const P* x, int64_t n, int64_t height, int64_t width, const int32_t* rows,
                   int64_t new_height, const int32_t* columns, int64_t new_width, int64_t step, double fill,
                   P* out) {
  const std::vector<Run> runs = runs_of(columns, new_width, width / step);
  const auto filled = as_pixel<P>(fill);
  const int64_t values = new_width * step;
#pragma omp parallel for
  for (int64_t row = 0; row < n * new_height; ++row) {
    const int64_t source = rows[row % new_height];
    P* const to = out + row * values;
    if (source < 0 || source >= height) {
      std::fill_n(to, values, filled);
      continue;
    }
    const P* const from = x + (row / new_height * height + source) * width;
    for (const Run& run : runs)
      if (run.from < 0)
        std::fill_n(to + run.to * step, run.pixels * step, filled);
      else
        std::memcpy(to + run.to * step, from + run.from * step,
                    sizeof(P) * static_cast<size_t>(run.pixels * step));
  }
}

CHIASM_INSTANTIATE(gather_pixels)

}  // namespace chiasm::kernels
