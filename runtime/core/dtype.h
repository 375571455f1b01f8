/** Names and sizes of the element types. */
#pragma once

#include <cstddef>
#include <string_view>

#include "chiasm/chiasm.h"

namespace chiasm::core {

struct DTypeEntry {
  const char* name;        /**< as in the manifest */
  const char* safetensors; /**< as in a safetensors header */
  size_t size;             /**< bytes of one element */
};

/** Indexed by chiasm_dtype. */
inline constexpr DTypeEntry kDTypes[] = {
    {"bool", "BOOL", 1}, {"uint8", "U8", 1},    {"int8", "I8", 1},      {"int16", "I16", 2},   {"int32", "I32", 4},
    {"int64", "I64", 8}, {"float16", "F16", 2}, {"bfloat16", "BF16", 2}, {"float32", "F32", 4}, {"float64", "F64", 8},
};
inline constexpr int32_t kDTypeCount = 10;

inline bool is_dtype(int64_t value) { return value >= 0 && value < kDTypeCount; }

/** Also for values that are no dtype, as messages need. */
inline const char* dtype_name(int64_t value) { return is_dtype(value) ? kDTypes[value].name : "an unknown dtype"; }

/** -1 where there is none of that name. */
inline int32_t dtype_from_name(std::string_view name) {
  for (int32_t i = 0; i < kDTypeCount; ++i) {
    if (name == kDTypes[i].name) return i;
  }
  return -1;
}

inline int32_t dtype_from_safetensors(std::string_view name) {
  for (int32_t i = 0; i < kDTypeCount; ++i) {
    if (name == kDTypes[i].safetensors) return i;
  }
  return -1;
}

}  // namespace chiasm::core
