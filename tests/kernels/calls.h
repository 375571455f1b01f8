// The functions that AOTInductor's code calls (the kernels' calls, runtime/artifact/aoti/operators.cpp), on
// tensors in guarded memory, for tests.
#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "artifact/aoti/tensor.h"
#include "guarded_memory.h"
#include "kernel_calls.h"

using Handle = AtenTensorOpaque*;
using Call = int32_t;

extern "C" {
Call aoti_torch_cpu_cumsum(Handle, int64_t, int32_t*, Handle*);
Call aoti_torch_cpu_addmm_out(Handle, Handle, Handle, Handle, double, double);
Call aoti_torch_cpu_baddbmm_out(Handle, Handle, Handle, Handle, double, double);
Call aoti_torch_cpu_bmm_out(Handle, Handle, Handle);
Call aoti_torch_cpu_mm_out(Handle, Handle, Handle);
Call aoti_torch_cpu_topk(Handle, int64_t, int64_t, int32_t, int32_t, Handle*, Handle*);
}

namespace kernel_calls {

using Tensor = std::unique_ptr<AtenTensorOpaque>;

/** The placement of new tensors, and the number of bytes that were written outside tensors that are already
 *  destroyed. */
extern guarded::Placement placement;
extern int damaged;
/** The text of the last call that failed. */
extern std::string last_error;

Tensor make(const chiasm::artifact::Dims& sizes, int32_t dtype);

template <class T>
constexpr int32_t kCode = -1;
template <>
inline constexpr int32_t kCode<uint8_t> = chiasm::artifact::kUint8;
template <>
inline constexpr int32_t kCode<int16_t> = chiasm::artifact::kInt16;
template <>
inline constexpr int32_t kCode<uint16_t> = chiasm::artifact::kUint16;
template <>
inline constexpr int32_t kCode<bool> = chiasm::artifact::kBool;
template <>
inline constexpr int32_t kCode<int32_t> = chiasm::artifact::kInt32;
template <>
inline constexpr int32_t kCode<int64_t> = chiasm::artifact::kInt64;
template <>
inline constexpr int32_t kCode<float> = chiasm::artifact::kFloat;
template <>
inline constexpr int32_t kCode<double> = chiasm::artifact::kDouble;

/** A tensor that is filled with the values, repeated. */
template <class T>
Tensor of(const chiasm::artifact::Dims& sizes, const std::vector<T>& values) {
  Tensor tensor = make(sizes, kCode<T>);
  auto* const data = reinterpret_cast<T*>(tensor->data());
  for (int64_t i = 0; i < tensor->numel(); ++i) data[i] = values[static_cast<size_t>(i) % values.size()];
  return tensor;
}

template <class T>
Tensor of(const chiasm::artifact::Dims& sizes, std::initializer_list<T> values) {
  return of(sizes, std::vector<T>(values));
}

}  // namespace kernel_calls
