/** Element types, ours and ONNX Runtime's. */
#pragma once

#include <onnxruntime_c_api.h>

#include <string>

#include "base/dtype.h"
#include "base/error.h"

namespace chiasm::onnx {

static_assert(base::kDTypes[CHIASM_FLOAT32].onnx == ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT &&
                  base::kDTypes[CHIASM_UINT16].onnx == ONNX_TENSOR_ELEMENT_DATA_TYPE_UINT16 &&
                  base::kDTypes[CHIASM_BFLOAT16].onnx == ONNX_TENSOR_ELEMENT_DATA_TYPE_BFLOAT16,
              "the table has ONNX's own numbers");

inline ONNXTensorElementDataType element_type(int32_t dtype) {
  if (!base::is_dtype(dtype))
    throw base::Error(CHIASM_INVALID_ARGUMENT, "unknown dtype " + std::to_string(dtype));
  return static_cast<ONNXTensorElementDataType>(base::kDTypes[dtype].onnx);
}

/** -1 for a type that chiasm does not have. */
inline int32_t dtype_of(ONNXTensorElementDataType type) {
  for (int32_t dtype = 0; dtype < base::kDTypeCount; ++dtype) {
    if (base::kDTypes[dtype].onnx == static_cast<int32_t>(type)) return dtype;
  }
  return -1;
}

}  // namespace chiasm::onnx
