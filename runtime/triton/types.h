/** Element types: their names in chiasm, in Triton and in config.pbtxt. */
#pragma once

#include <triton/core/tritonserver.h>

#include <cstddef>

#include "base/dtype.h"
#include "chiasm/chiasm.hpp"

namespace chiasm::triton {

struct TypeEntry {
  TRITONSERVER_DataType triton;
  const char* config;
};

/** Indexed by chiasm_dtype. chiasm has no dtype for Triton's TYPE_BYTES (strings) and unsigned types of 32
 *  and 64 bits. */
inline constexpr TypeEntry kTypes[] = {
    {TRITONSERVER_TYPE_BOOL, "TYPE_BOOL"},      //
    {TRITONSERVER_TYPE_UINT8, "TYPE_UINT8"},    //
    {TRITONSERVER_TYPE_INT8, "TYPE_INT8"},      //
    {TRITONSERVER_TYPE_INT16, "TYPE_INT16"},    //
    {TRITONSERVER_TYPE_INT32, "TYPE_INT32"},    //
    {TRITONSERVER_TYPE_INT64, "TYPE_INT64"},    //
    {TRITONSERVER_TYPE_FP16, "TYPE_FP16"},      //
    {TRITONSERVER_TYPE_BF16, "TYPE_BF16"},      //
    {TRITONSERVER_TYPE_FP32, "TYPE_FP32"},      //
    {TRITONSERVER_TYPE_FP64, "TYPE_FP64"},      //
    {TRITONSERVER_TYPE_UINT16, "TYPE_UINT16"},  //
};
static_assert(sizeof kTypes / sizeof kTypes[0] == base::kDTypeCount, "a line for each element type");

inline const TypeEntry& type_of(DType dtype) { return kTypes[static_cast<int32_t>(dtype)]; }
inline size_t size_of(DType dtype) { return base::kDTypes[static_cast<int32_t>(dtype)].size; }

}  // namespace chiasm::triton
