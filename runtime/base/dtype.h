/** Names and sizes of the element types. */
#pragma once

#include <cstddef>
#include <string_view>

#include "chiasm/chiasm.h"

namespace chiasm::base {

struct DTypeEntry {
  chiasm_dtype dtype;
  const char* name;        /**< as in the manifest, NumPy and PyTorch */
  const char* safetensors; /**< as in a safetensors header */
  size_t size;             /**< bytes of one element */
  int32_t dlpack;          /**< its DLDataTypeCode */
  char numpy_kind;         /**< numpy.dtype.kind; 'V' if NumPy has no such type */
  int32_t onnx;            /**< its TensorProto.DataType, which is ONNXTensorElementDataType too */
  int32_t torch;           /**< its c10::ScalarType */
  const char* triton;      /**< as Triton's requests name it; with TYPE_ in front, as config.pbtxt does */
};

/** The one table of element types, in the order of chiasm_dtype: docs/howto/dtype.md adds a line to it. It is
 *  a macro because the functions by which AOTInductor's code asks for a type have the type's name in theirs.
 */
#define CHIASM_DTYPES(X)                                          \
  X(CHIASM_BOOL, bool, "BOOL", 1, 6, 'b', 9, 11, "BOOL")          \
  X(CHIASM_UINT8, uint8, "U8", 1, 1, 'u', 2, 0, "UINT8")          \
  X(CHIASM_INT8, int8, "I8", 1, 0, 'i', 3, 1, "INT8")             \
  X(CHIASM_INT16, int16, "I16", 2, 0, 'i', 5, 2, "INT16")         \
  X(CHIASM_INT32, int32, "I32", 4, 0, 'i', 6, 3, "INT32")         \
  X(CHIASM_INT64, int64, "I64", 8, 0, 'i', 7, 4, "INT64")         \
  X(CHIASM_FLOAT16, float16, "F16", 2, 2, 'f', 10, 5, "FP16")     \
  X(CHIASM_BFLOAT16, bfloat16, "BF16", 2, 4, 'V', 16, 15, "BF16") \
  X(CHIASM_FLOAT32, float32, "F32", 4, 2, 'f', 1, 6, "FP32")      \
  X(CHIASM_FLOAT64, float64, "F64", 8, 2, 'f', 11, 7, "FP64")     \
  X(CHIASM_UINT16, uint16, "U16", 2, 1, 'u', 4, 27, "UINT16")

#define CHIASM_DTYPE_ENTRY(dtype, name, ...) {dtype, #name, __VA_ARGS__},
/** Indexed by chiasm_dtype. */
inline constexpr DTypeEntry kDTypes[] = {CHIASM_DTYPES(CHIASM_DTYPE_ENTRY)};
#undef CHIASM_DTYPE_ENTRY
inline constexpr int32_t kDTypeCount = sizeof kDTypes / sizeof kDTypes[0];

/** Values of chiasm_dtype are stored in programs: neither list changes its order without the other. */
constexpr bool in_order() {
  for (int32_t i = 0; i < kDTypeCount; ++i) {
    if (kDTypes[i].dtype != i) return false;
  }
  return true;
}
static_assert(in_order(), "a line of CHIASM_DTYPES is not at the index of its chiasm_dtype: append new ones");

inline bool is_dtype(int64_t value) { return value >= 0 && value < kDTypeCount; }

/** Also accepts values that are no dtype, for messages. */
inline const char* dtype_name(int64_t value) {
  return is_dtype(value) ? kDTypes[value].name : "an unknown dtype";
}

/** -1 if there is no dtype of that name. */
inline int32_t dtype_from_name(std::string_view name) {
  for (int32_t i = 0; i < kDTypeCount; ++i) {
    if (name == kDTypes[i].name) return i;
  }
  return -1;
}

/** How many elements a tensor has. */
inline size_t element_count(const chiasm_tensor& tensor) {
  size_t count = 1;
  for (int32_t i = 0; i < tensor.ndim; ++i) count *= static_cast<size_t>(tensor.shape[i]);
  return count;
}

/** The bytes of a dense tensor, whose dtype must be valid. */
inline size_t byte_count(const chiasm_tensor& tensor) {
  return element_count(tensor) * kDTypes[tensor.dtype].size;
}

inline int32_t dtype_from_safetensors(std::string_view name) {
  for (int32_t i = 0; i < kDTypeCount; ++i) {
    if (name == kDTypes[i].safetensors) return i;
  }
  return -1;
}

}  // namespace chiasm::base
