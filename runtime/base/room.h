/** Whether the process may have more memory. */
#pragma once

#include <sys/mman.h>

#include <cstddef>

namespace chiasm::base {

/** Whether the process can map `bytes` more now. The memory is released at once, so other threads may take
 *  it. */
inline bool has_room(size_t bytes) {
  void* const room = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return room != MAP_FAILED && ::munmap(room, bytes) == 0;
}

}  // namespace chiasm::base
