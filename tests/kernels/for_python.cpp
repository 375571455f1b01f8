// The kernels' calls for Python (tests/ops/called_kernels.py), on tensors in guarded memory.
#include "calls.h"
#include "threads.h"

using chiasm::base::kDTypes;

namespace {

struct Known {
  const char* name;
  void (*call)();
};

const Known kKernels[] = {
#include "named_calls.inc"
};

}  // namespace

extern "C" {

struct chiasm_kernel_view {
  const char* dtype;
  int64_t dims;
  const int64_t* sizes;
  void* data;
};

/** The C function of a kernel, for this thread; null if there is no such kernel. */
CHIASM_EXPORT void (*chiasm_kernel_function(const char* name))() {
  use_threads(1);
  for (const Known& known : kKernels)
    if (std::strcmp(known.name, name) == 0) return known.call;
  return nullptr;
}

/** The text of the last call that failed. */
CHIASM_EXPORT const char* chiasm_kernel_error() { return kernel_calls::last_error.c_str(); }

/** A new tensor, whose values are to be written. */
CHIASM_EXPORT Handle chiasm_kernel_tensor(const char* dtype, int64_t dims, const int64_t* sizes) {
  const int32_t code = kDTypes[chiasm::base::dtype_from_name(dtype)].torch;
  return kernel_calls::make({sizes, sizes + dims}, code).release();
}

CHIASM_EXPORT chiasm_kernel_view chiasm_kernel_look(Handle tensor) {
  const auto* const entry =
      std::find_if(std::begin(kDTypes), std::end(kDTypes),
                   [=](const chiasm::base::DTypeEntry& known) { return known.torch == tensor->dtype; });
  const auto& sizes = tensor->sizes;
  return {entry->name, static_cast<int64_t>(sizes.size()), sizes.data(), tensor->data()};
}

/** Returns whether bytes around the tensor have been changed. */
CHIASM_EXPORT int32_t chiasm_kernel_free(Handle tensor) {
  const int before = kernel_calls::damaged;
  delete tensor;
  return kernel_calls::damaged != before;
}

}  // extern "C"
