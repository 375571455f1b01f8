// The memory of tensors in artifacts for the CPU; cuda.cpp has that for GPUs.
#include <cstring>

#include "memory.h"

namespace chiasm::artifact::memory {

const bool host_can_read = true;
const int64_t most_elements = int64_t{1} << 56;

void copy(void* to, const void* from, size_t bytes) { std::memcpy(to, from, bytes); }
void zero(void* data, size_t bytes) { std::memset(data, 0, bytes); }
void read(void* to, const void* from, size_t bytes) { std::memcpy(to, from, bytes); }
void wait_for_all() {}

}  // namespace chiasm::artifact::memory
