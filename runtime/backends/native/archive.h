/** Finds the shared library in a native artifact. */
#pragma once

#include <cstddef>

namespace chiasm::native {

/** Bytes inside others. */
struct Bytes {
  const unsigned char* data;
  std::size_t size;
};

/** A `.pt2` is a zip archive whose entries are stored, not compressed. Returns its one `*.so`, a view of the
 *  archive's own bytes; throws Error (CORRUPT) if the archive is damaged, compressed, or has none or several.
 *
 *  Checksums are not compared: the caller has compared the hash of the bytes with the manifest's. */
Bytes find_library(const void* data, std::size_t size);

}  // namespace chiasm::native
