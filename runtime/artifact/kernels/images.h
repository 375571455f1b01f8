// The sizes that most kernels take: tensors are dense and row-major.
#pragma once

#include <cstdint>

namespace chiasm::kernels {

struct Planes {
  int64_t count, height, width;
};

struct Images {
  int64_t count, channels, height, width;
  Planes planes() const { return {count * channels, height, width}; }
};

}  // namespace chiasm::kernels
