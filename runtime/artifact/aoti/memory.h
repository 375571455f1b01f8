// What is done with the memory of tensors besides the op's own code. On the CPU (memory_cpu.cpp) it is done when
// these return; on CUDA (cuda.cpp) it is enqueued on the run's stream, but for `read`, which waits.
#pragma once

#include <cstddef>
#include <cstdint>

namespace chiasm::artifact::memory {

void copy(void* to, const void* from, size_t bytes);
void zero(void* data, size_t bytes);
// To a variable of the host.
void read(void* to, const void* from, size_t bytes);
// Nothing that the model enqueued is left to do.
void wait_for_all();

// Whether the host can read the memory of tensors.
extern const bool host_can_read;
// The most elements that a tensor may have: those which the op's code can count.
extern const int64_t most_elements;

}  // namespace chiasm::artifact::memory
