// Operations on the memory of tensors, outside the op's own code. On the CPU (memory_cpu.cpp) they are done
// when they return; on CUDA (cuda.cpp) they are enqueued on the run's stream, except `read`, which waits.
#pragma once

#include <cstddef>
#include <cstdint>

namespace chiasm::artifact::memory {

void copy(void* to, const void* from, size_t bytes);
void zero(void* data, size_t bytes);
// To a variable of the host.
void read(void* to, const void* from, size_t bytes);
// Waits until everything that the model enqueued is done.
void wait_for_all();

// Whether the host can read the memory of tensors.
extern const bool host_can_read;
// The most elements that a tensor may have: the op's code cannot index more.
extern const int64_t most_elements;

}  // namespace chiasm::artifact::memory
