/** Opening libraries. */
#pragma once

#include <dlfcn.h>

#include <cerrno>
#include <cstring>
#include <new>
#include <string>

#include "base/error.h"

namespace chiasm::base {

/** Opens a library whose symbols nothing else sees. Returns NULL if it cannot be opened; `problem` then has
 *  the reason. Throws std::bad_alloc or Error (IO_ERROR) if the process has no memory or file descriptor
 *  left: this is no fault of the library, and may be temporary. */
inline void* open_library(const char* path, std::string& problem) {
  errno = 0;
  void* const library = ::dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (library != nullptr) return library;
  if (errno == ENOMEM) throw std::bad_alloc();
  const char* const text = ::dlerror();
  problem = text == nullptr ? "unknown error of the dynamic linker" : text;
  for (const int reason : {EMFILE, ENFILE}) {  // glibc does not leave these in errno
    if (problem.find(std::strerror(reason)) != std::string::npos) fail(CHIASM_IO_ERROR, problem);
  }
  return nullptr;
}

}  // namespace chiasm::base
