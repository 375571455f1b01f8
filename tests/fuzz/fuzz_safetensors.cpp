/** Reads any bytes as safetensors: the result is tensors that lie within the file, or an Error. */
#include <cstdlib>

#include "core/safetensors.h"
#include "core/status.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    for (const auto& [name, tensor] : chiasm::core::read_safetensors(data, size, "fuzz")) {
      if (tensor.data < data || tensor.size > static_cast<size_t>(data + size - tensor.data)) std::abort();
    }
  } catch (const chiasm::core::Error&) {}
  return 0;
}
