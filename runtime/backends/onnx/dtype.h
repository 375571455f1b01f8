/** Element types, ours and ONNX Runtime's. */
#pragma once

#include <onnxruntime_c_api.h>

#include <string>

#include "backends/plugin.h"

namespace chiasm::onnx {

inline ONNXTensorElementDataType element_type(int32_t dtype) {
  switch (dtype) {
    case CHIASM_BOOL: return ONNX_TENSOR_ELEMENT_DATA_TYPE_BOOL;
    case CHIASM_UINT8: return ONNX_TENSOR_ELEMENT_DATA_TYPE_UINT8;
    case CHIASM_INT8: return ONNX_TENSOR_ELEMENT_DATA_TYPE_INT8;
    case CHIASM_INT16: return ONNX_TENSOR_ELEMENT_DATA_TYPE_INT16;
    case CHIASM_INT32: return ONNX_TENSOR_ELEMENT_DATA_TYPE_INT32;
    case CHIASM_INT64: return ONNX_TENSOR_ELEMENT_DATA_TYPE_INT64;
    case CHIASM_FLOAT16: return ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT16;
    case CHIASM_BFLOAT16: return ONNX_TENSOR_ELEMENT_DATA_TYPE_BFLOAT16;
    case CHIASM_FLOAT32: return ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT;
    case CHIASM_FLOAT64: return ONNX_TENSOR_ELEMENT_DATA_TYPE_DOUBLE;
    default: throw plugin::Error(CHIASM_INVALID_ARGUMENT, "unknown dtype " + std::to_string(dtype));
  }
}

/** -1 for a type that chiasm does not have. */
inline int32_t dtype_of(ONNXTensorElementDataType type) {
  for (int32_t dtype = CHIASM_BOOL; dtype <= CHIASM_FLOAT64; ++dtype) {
    if (element_type(dtype) == type) return dtype;
  }
  return -1;
}

}  // namespace chiasm::onnx
