// Writes the signature line by line; symbols are sorted, because JSON objects have no order.
#include "core/signature_text.h"

#include <algorithm>

#include "base/dtype.h"

namespace chiasm::core {
namespace {

void add_tensors(std::string& text, const char* kind, const std::vector<TensorSpec>& tensors,
                 uint64_t batched, int32_t generic_dtype) {
  for (size_t i = 0; i < tensors.size(); ++i) {
    const TensorSpec& tensor = tensors[i];
    text += std::string(kind) + " " + tensor.name + " " +
            dtype_name(tensor.dtype == kGeneric ? generic_dtype : tensor.dtype) + " [";
    for (size_t d = 0; d < tensor.shape.size(); ++d) text += (d == 0 ? "" : ", ") + tensor.shape[d].text();
    text += (batched >> i & 1) != 0 ? "] batched\n" : "]\n";
  }
}

}  // namespace

std::string signature_text(const MethodSpec& method, const std::vector<Symbol>& symbols,
                           int32_t generic_dtype) {
  std::vector<std::string> limits;
  for (const Symbol& symbol : symbols) {
    limits.push_back("symbol " + symbol.name + " " + std::to_string(symbol.min) + " " +
                     std::to_string(symbol.max) + "\n");
  }
  std::sort(limits.begin(), limits.end());  // JSON objects have no order
  std::string text = "chiasm 1\n";
  for (const std::string& line : limits) text += line;
  add_tensors(text, "input", method.inputs, method.batched_inputs, generic_dtype);
  add_tensors(text, "output", method.outputs, method.batched_outputs, generic_dtype);
  return text;
}

}  // namespace chiasm::core
