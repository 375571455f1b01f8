/** Element types: their names in chiasm, in Triton and in config.pbtxt. */
#pragma once

#include <triton/core/tritonserver.h>

#include <cstddef>
#include <string>

#include "base/dtype.h"
#include "chiasm/chiasm.hpp"

namespace chiasm::triton {

inline const base::DTypeEntry& entry_of(DType dtype) { return base::kDTypes[static_cast<int32_t>(dtype)]; }
inline TRITONSERVER_DataType type_of(DType dtype) {
  return TRITONSERVER_StringToDataType(entry_of(dtype).triton);
}
inline std::string config_type_of(DType dtype) { return std::string("TYPE_") + entry_of(dtype).triton; }
inline size_t size_of(DType dtype) { return entry_of(dtype).size; }

}  // namespace chiasm::triton
