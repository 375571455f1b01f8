/** Opening libraries. */
#pragma once

#include <dlfcn.h>

#include <cerrno>
#include <new>

namespace chiasm::base {

/** Opens a library whose symbols nothing else sees. NULL where it cannot be opened: dlerror says why. Throws
 *  std::bad_alloc where the linker had no memory: that is no fault of the library, and may pass. */
inline void* open_library(const char* path) {
  errno = 0;
  void* const library = ::dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr && errno == ENOMEM) throw std::bad_alloc();
  return library;
}

}  // namespace chiasm::base
