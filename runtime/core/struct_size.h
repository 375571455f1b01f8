/** Structs of callers that were compiled against an older or a newer header. */
#pragma once

#include <cstddef>
#include <string>

#include "core/status.h"

namespace chiasm::core {

/** The size of a struct that ends with `member`: the least struct_size of a caller for which the library may
 *  read that member. */
#define CHIASM_SIZE_THROUGH(type, member) (offsetof(type, member) + sizeof(type::member))

/** Throws Error (INVALID_ARGUMENT) if a caller's struct is smaller than `first`, its size when it was first
 *  published. */
inline void check_struct_size(size_t struct_size, size_t first, const std::string& what,
                              const std::string& remedy) {
  if (struct_size >= first) return;
  fail(CHIASM_INVALID_ARGUMENT, what + ": struct_size is " + std::to_string(struct_size) +
                                    ", expected at least " + std::to_string(first) + ": " + remedy);
}

}  // namespace chiasm::core
