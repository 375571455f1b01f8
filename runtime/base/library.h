/** Opening libraries, and finding one's own. */
#pragma once

#include <dlfcn.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

#include "base/error.h"

namespace chiasm::base {

/** What happens to symbolic links in a path. */
enum class Links { kept, followed };

/** The folder of the library that this code is in, by the path that it was opened with; "" if unknown. */
inline std::string own_folder(Links links) {
  static const char here = 0;
  Dl_info info{};
  if (::dladdr(&here, &info) == 0 || info.dli_fname == nullptr) return "";
  char* const resolved = links == Links::followed ? ::realpath(info.dli_fname, nullptr) : nullptr;
  const std::string path = resolved == nullptr ? info.dli_fname : resolved;
  std::free(resolved);
  const size_t slash = path.rfind('/');
  return slash == std::string::npos ? "." : path.substr(0, std::max<size_t>(slash, 1));
}

/** Whether the process has no address space left for a library of this file's size. The linker gives no
 *  reason for a failed mapping. */
inline bool lacks_room_for(const char* path) {
  struct stat file {};
  if (::stat(path, &file) != 0) return false;
  // twice, because a library also maps memory that is not in its file
  const size_t size = 2 * static_cast<size_t>(file.st_size) + (size_t{1} << 20);
  void* const room = ::mmap(nullptr, size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (room == MAP_FAILED) return true;
  ::munmap(room, size);
  return false;
}

/** Opens a library whose symbols nothing else sees. Returns NULL if it cannot be opened; `problem` then has
 *  the reason. Throws std::bad_alloc or Error (IO_ERROR) if the process has no memory or file descriptor
 *  left: this is no fault of the library, and may be temporary. */
inline void* open_library(const char* path, std::string& problem) {
  struct stat file {};
  if (std::strchr(path, '/') != nullptr && ::stat(path, &file) == 0 && !S_ISREG(file.st_mode)) {
    problem = "not a regular file";  // the linker would wait for a pipe's writer
    return nullptr;
  }
  errno = 0;
  void* const library = ::dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (library != nullptr) return library;
  if (errno == ENOMEM || lacks_room_for(path)) throw std::bad_alloc();
  const char* const text = ::dlerror();
  problem = text == nullptr ? "unknown error of the dynamic linker" : text;
  for (const int reason : {EMFILE, ENFILE}) {  // glibc does not leave these in errno
    if (problem.find(std::strerror(reason)) != std::string::npos) fail(CHIASM_IO_ERROR, problem);
  }
  return nullptr;
}

}  // namespace chiasm::base
