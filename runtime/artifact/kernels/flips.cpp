// Mirror images.
#include "rows.h"

namespace chiasm::kernels {

template <class T>
void hflip(const T* x, Planes planes, T* out) {
  const int64_t width = planes.width;
#pragma omp parallel for
  for (int64_t row = 0; row < planes.count * planes.height; ++row) {
    const T* const end = x + (row + 1) * width;
    T* const target = out + row * width;
    for_lanes<T, 4>(width, [=](auto d, auto vectors, int64_t k) {
      const auto lanes = static_cast<int64_t>(hn::Lanes(d));
      for (int v = 0; v < vectors; ++v)
        hn::StoreU(hn::Reverse(d, hn::LoadU(d, end - k - (v + 1) * lanes)), d, target + k + v * lanes);
    });
  }
}

CHIASM_INSTANTIATE(hflip)

}  // namespace chiasm::kernels
