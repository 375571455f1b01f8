/** Reads any bytes as a model: the result is a model with all its data inside, or an Error. A tensor with
 *  external data is rejected, whatever surrounds it. */
#include <cstdlib>

#include "backends/onnx/onnx_file.h"
#include "core/status.h"

namespace {

bool passes(const std::string& model) {
  try {
    chiasm::onnx::check_onnx(reinterpret_cast<const unsigned char*>(model.data()), model.size(), "fuzz");
    return true;
  } catch (const chiasm::core::Error&) {
    return false;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string model(reinterpret_cast<const char*>(data), size),
      external("\x3a\x04\x2a\x02\x70\x01", 6);  // graph { initializer { data_location: EXTERNAL } }
  if (passes(model) && (passes(model + external) || passes(external + model))) std::abort();
  return 0;
}
