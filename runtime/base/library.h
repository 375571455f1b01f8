/** Opening libraries. */
#pragma once

#include <dlfcn.h>

#include <cerrno>
#include <cstring>
#include <new>
#include <string>

#include "base/error.h"

namespace chiasm::base {

/** Opens a library whose symbols nothing else sees. NULL where it cannot be opened: `problem` says why. Throws
 *  std::bad_alloc or Error (IO_ERROR) where the linker had no memory or no file: that is no fault of the
 *  library, and may pass. */
inline void* open_library(const char* path, std::string& problem) {
  errno = 0;
  void* const library = ::dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (library != nullptr) return library;
  if (errno == ENOMEM) throw std::bad_alloc();
  const char* const text = ::dlerror();
  problem = text == nullptr ? "unknown error of the dynamic linker" : text;
  for (const int reason : {EMFILE, ENFILE}) {  // of which glibc leaves no errno
    if (problem.find(std::strerror(reason)) != std::string::npos) fail(CHIASM_IO_ERROR, problem);
  }
  return nullptr;
}

}  // namespace chiasm::base
