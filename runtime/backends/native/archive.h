/** Reads the shared library out of a native artifact. */
#pragma once

#include <cstddef>

#include "backends/plugin.h"

namespace chiasm::native {

/** A `.pt2` is a zip archive. Returns its one `*.so` as a sealed file in memory; throws Error(CHIASM_CORRUPT) where the
 *  archive is damaged or has none or several. */
plugin::MemoryFile extract_library(const void* data, std::size_t size);

}  // namespace chiasm::native
