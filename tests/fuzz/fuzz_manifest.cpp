/** Reads any bytes as a manifest: the result is a manifest or an Error. */
#include "core/info.h"
#include "core/manifest.h"
#include "core/status.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    const auto manifest = chiasm::core::parse_manifest({reinterpret_cast<const char*>(data), size}, "fuzz");
    for (const auto& method : manifest.methods)
      chiasm::core::MethodInfo(method, manifest.symbols, manifest.dtypes);
  } catch (const chiasm::core::Error&) {}
  return 0;
}
