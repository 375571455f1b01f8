/** How libchiasm_ort tells the onnx backend a chiasm_code through ONNX Runtime, which passes on the text of
 *  an error alone. */
#pragma once

#include <cstdio>
#include <string>

#include "chiasm/chiasm.h"

/** What a message ends with, for printf. */
#define CHIASM_CODE_IN_TEXT " [chiasm code %d]"

namespace chiasm::onnx {

/** Takes the code out of the text; CHIASM_OK where it has none. */
inline chiasm_code take_code(std::string& text) {
  const size_t at = text.rfind(" [chiasm code ");
  int code = CHIASM_OK;
  if (at == std::string::npos || std::sscanf(text.c_str() + at, CHIASM_CODE_IN_TEXT, &code) != 1)
    return CHIASM_OK;
  text.erase(at, text.find(']', at) + 1 - at);
  return static_cast<chiasm_code>(code);
}

}  // namespace chiasm::onnx
