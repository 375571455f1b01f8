// Connected sets of pixels.
#include <cstring>
#include <numeric>

#include "rows.h"

namespace chiasm::kernels {
namespace {

// The root of a tree; on the way every other pixel is hung below its grandparent.
int32_t root(int32_t* parent, int32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

// Hangs the higher of two roots below the lower.
void join(int32_t* parent, int32_t a, int32_t b) {
  a = root(parent, a);
  b = root(parent, b);
  parent[std::max(a, b)] = std::min(a, b);
}

}  // namespace

void connected_components(const bool* mask, int64_t planes, int64_t height, int64_t width, int32_t* roots) {
  const int64_t size = height * width;
#pragma omp parallel for
  for (int64_t plane = 0; plane < planes; ++plane) {
    // a caller's bytes: what is not 0 is set
    const auto* const set = reinterpret_cast<const uint8_t*>(mask) + plane * size;
    int32_t* const parent = roots + plane * size;
    std::iota(parent, parent + size, 0);
    for (int64_t y = 0; y < height; ++y)
      for (int64_t x = 0; x < width; ++x) {
        const int64_t i = y * width + x;
        if (!set[i]) continue;
        const auto own = static_cast<int32_t>(i);
        if (y > 0) {
          const int64_t up = i - width;
          if (set[up]) {  // touches all other neighbours before this one
            parent[i] = root(parent, static_cast<int32_t>(up));
            continue;
          }
          if (x + 1 < width && set[up + 1]) join(parent, own, static_cast<int32_t>(up + 1));
          if (x > 0 && set[up - 1]) join(parent, own, static_cast<int32_t>(up - 1));
        }
        if (x > 0 && set[i - 1]) join(parent, own, static_cast<int32_t>(i - 1));
      }
    // A parent comes before its children.
    for (int64_t i = 0; i < size; ++i) parent[i] = parent[parent[i]];
  }
}

template <class T>
void canny_hysteresis(const T* x, Planes planes, T low, T high, bool* out) {
  const Lanes<T> d;
  const int64_t height = planes.height, width = planes.width, size = height * width;
  // Every pixel is put aside at most once. The room is reserved here and not touched before it is used.
  const std::unique_ptr<int32_t[]> scratch(new int32_t[static_cast<size_t>(size * omp_get_max_threads())]);
  std::memset(out, 0, static_cast<size_t>(planes.count * size));
#pragma omp parallel
  {
    int32_t* const stack = scratch.get() + size * omp_get_thread_num();
#pragma omp for
    for (int64_t plane = 0; plane < planes.count; ++plane) {
      const T* const values = x + plane * size;
      bool* const found = out + plane * size;
      const auto follow = [&](int64_t start) {
        if (!(values[start] > high) || found[start]) return;
        found[start] = true;
        int64_t count = 0;
        stack[count++] = static_cast<int32_t>(start);
        while (count > 0) {
          const int64_t i = stack[--count], r = i / width, c = i - r * width;
          for (int64_t v = std::max<int64_t>(r - 1, 0); v <= std::min(r + 1, height - 1); ++v)
            for (int64_t u = std::max<int64_t>(c - 1, 0); u <= std::min(c + 1, width - 1); ++u) {
              const int64_t j = v * width + u;
              if (!(values[j] > low) || found[j]) continue;
              found[j] = true;
              stack[count++] = static_cast<int32_t>(j);
            }
        }
      };
      int64_t i = 0;
      for (; i + kLanes<T> <= size; i += kLanes<T>)
        if (any(d, hn::Gt(hn::LoadU(d, values + i), hn::Set(d, high))))
          for (int64_t k = 0; k < kLanes<T>; ++k) follow(i + k);
      for (; i < size; ++i) follow(i);
    }
  }
}

CHIASM_INSTANTIATE(canny_hysteresis)

}  // namespace chiasm::kernels
