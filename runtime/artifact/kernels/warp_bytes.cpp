// Reads images of bytes at positions.
#include "declared/warp_bytes.h"
#include "bicubic_bytes.h"
#include "bilinear_bytes.h"
#include "read_runs.h"

namespace chiasm::kernels {
namespace {

using namespace bytes;

template <class Positions>
void read_at(const uint8_t* images, int64_t n, int64_t items, const Source& source, int64_t out_height,
             int64_t out_width, Interpolation mode, Fill<uint8_t> fill, uint8_t* out,
             const Positions& positions) {
  switch (mode) {
    case Interpolation::kNearest:
      return read_with<Nearest>(images, n, items, source, out_height, out_width, fill, out, positions);
    case Interpolation::kBilinear:
      return read_with<Bilinear>(images, n, items, source, out_height, out_width, fill, out, positions);
    case Interpolation::kBicubic:
      return read_with<Bicubic>(images, n, items, source, out_height, out_width, fill, out, positions);
  }
}

}  // namespace

template <class T>
void remap_bytes(const uint8_t* image, int64_t n, int64_t height, int64_t width, const T* x, int64_t items,
                 int64_t out_height, int64_t out_width, const T* y, int64_t step, Interpolation mode,
                 Padding padding, bool align_corners, const uint8_t* fill, int64_t fills, uint8_t* out) {
  read_at(image, n, items, {height, width / step, step, 0, padding, align_corners}, out_height, out_width,
          mode, {fill, fills}, out, Given<T>{x, y, out_height, out_width});
}

void warp_bytes(const uint8_t* image, int64_t n, int64_t height, int64_t width, const double* matrix,
                int64_t items, int64_t out_height, int64_t out_width, int64_t step, Interpolation mode,
                Padding padding, bool align_corners, const uint8_t* fill, int64_t fills, uint8_t* out) {
  read_at(image, n, items, {height, width / step, step, 0, padding, align_corners}, out_height, out_width,
          mode, {fill, fills}, out, Mapped{matrix});
}

CHIASM_INSTANTIATE(remap_bytes)

}  // namespace chiasm::kernels
