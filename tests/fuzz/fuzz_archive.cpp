/** Reads any bytes as a native artifact: the result is its library, which lies inside them, or an Error. */
#include <cstdlib>

#include "backends/native/archive.h"
#include "base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    const chiasm::native::Bytes library = chiasm::native::find_library(data, size);
    if (library.data < data || library.size > size || library.data + library.size > data + size) std::abort();
  } catch (const chiasm::base::Error&) {}
  return 0;
}
