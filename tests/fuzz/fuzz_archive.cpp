/** Any bytes as a native artifact: its library in memory, or an Error. */
#include "backends/native/archive.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    chiasm::native::extract_library(data, size);
  } catch (const chiasm::plugin::Error&) {
  }
  return 0;
}
