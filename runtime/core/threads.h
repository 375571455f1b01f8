/** The one thread policy of the process. */
#pragma once

#include <cstdint>
#include <string>

namespace chiasm::core {

/** Throws Error (INVALID_ARGUMENT), naming `what`, for an invalid number of threads. */
void check_num_threads(int32_t count, const std::string& what);

/** 0: all cores this process may run on. Throws Error (FAILED_PRECONDITION) once it was used. */
void set_num_threads(int32_t count);
/** Always > 0. */
int32_t get_num_threads();
/** The number of threads; from now on it can no longer be set. */
int32_t use_num_threads();

}  // namespace chiasm::core
