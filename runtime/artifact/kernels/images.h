// The sizes that most kernels take: tensors are dense and row-major.
#pragma once

#include <cstdint>

namespace chiasm::kernels {

// Rows of `width` values, in which neighbours are `step` apart: 1 in a plane, the number of channels if they
// are interleaved. Borders count pixels: value i of a row belongs to pixel i / step.
struct Planes {
  int64_t count, height, width, step = 1;
};

struct Images {
  int64_t count, channels, height, width;
  Planes planes() const { return {count * channels, height, width}; }
};

}  // namespace chiasm::kernels
