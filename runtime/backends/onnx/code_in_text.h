/** libchiasm_ort passes a chiasm_code to the onnx backend inside the text of an error, because ONNX Runtime
 *  passes on nothing else. */
#pragma once

#include <cstdio>
#include <string>

#include "chiasm/chiasm.h"

/** The end of such a message, as a printf format. */
#define CHIASM_CODE_IN_TEXT " [chiasm code %d]"

namespace chiasm::onnx {

/** Removes the code from the text and returns it; CHIASM_OK if the text has none. */
inline chiasm_code take_code(std::string& text) {
  const size_t at = text.rfind(" [chiasm code ");
  int code = CHIASM_OK;
  if (at == std::string::npos || std::sscanf(text.c_str() + at, CHIASM_CODE_IN_TEXT, &code) != 1)
    return CHIASM_OK;
  text.erase(at, text.find(']', at) + 1 - at);
  return static_cast<chiasm_code>(code);
}

}  // namespace chiasm::onnx
