/** Whether the process may have more memory. */
#pragma once

#include <sys/mman.h>

#include <cstddef>

namespace chiasm::base {

/** Whether the process may map `bytes` more now. They are given back at once: other threads may take them. */
inline bool has_room(size_t bytes) {
  void* const room = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return room != MAP_FAILED && ::munmap(room, bytes) == 0;
}

}  // namespace chiasm::base
