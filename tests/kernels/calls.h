// What AOTInductor's code calls (runtime/artifact/aoti/kernels.cpp, fallbacks.cpp), for tests: on tensors in guarded memory.
#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "guarded_memory.h"
#include "artifact/aoti/tensor.h"

using Handle = AtenTensorOpaque*;
using Call = int32_t;

extern "C" {
Call aoti_torch_cpu_frame_to_grey(Handle, Handle*);
Call aoti_torch_cpu_resize_frame(Handle, int64_t, int64_t, Handle*);
Call aoti_torch_cpu_separable(Handle, Handle, Handle, int64_t, double, double, Handle*);
Call aoti_torch_cpu_correlate2d(Handle, Handle, int64_t, Handle*);
Call aoti_torch_cpu_bilateral(Handle, Handle, Handle, Handle, int64_t, int32_t, Handle*);
Call aoti_torch_cpu_rectangle_extreme(Handle, int64_t, int64_t, int64_t, double, int32_t, Handle*);
Call aoti_torch_cpu_structured_extreme(Handle, Handle, int64_t, int64_t, int64_t, double, double, int32_t, Handle*);
Call aoti_torch_cpu_structured_range(Handle, Handle, Handle, int64_t, int64_t, int64_t, double, double, double, Handle*);
Call aoti_torch_cpu_median3x3(Handle, int64_t, Handle*);
Call aoti_torch_cpu_integral(Handle, Handle*);
Call aoti_torch_cpu_sample(Handle, Handle, Handle, int64_t, int64_t, int32_t, Handle*);
Call aoti_torch_cpu_sample_projective(Handle, Handle, int64_t, int64_t, int64_t, int64_t, int32_t, Handle*);
Call aoti_torch_cpu_resize(Handle, int64_t, int64_t, int64_t, int32_t, int32_t, Handle*);
Call aoti_torch_cpu_resize_blurred(Handle, Handle, int64_t, int64_t, int32_t, int64_t, int32_t, Handle*);
Call aoti_torch_cpu_sobel(Handle, double, double, Handle*);
Call aoti_torch_cpu_ridges(Handle, double, Handle*);
Call aoti_torch_cpu_extents(Handle, Handle*);
Call aoti_torch_cpu_to_levels(Handle, Handle*);
Call aoti_torch_cpu_bin_counts(Handle, Handle, Handle, int64_t, Handle*);
Call aoti_torch_cpu_count_each(Handle, int64_t, Handle*);
Call aoti_torch_cpu_look_up(Handle, Handle, Handle*);
Call aoti_torch_cpu_tile_counts(Handle, int64_t, int64_t, int64_t, int64_t, Handle*);
Call aoti_torch_cpu_blend_curves(Handle, int64_t, Handle, Handle, Handle, Handle, Handle, Handle, Handle, Handle*);
Call aoti_torch_cpu_component_roots(Handle, Handle*);
Call aoti_torch_cpu_hysteresis(Handle, double, double, Handle*);
Call aoti_torch_cpu_cheapest_models(Handle, Handle, int32_t, int64_t, Handle*);
Call aoti_torch_cpu_real_roots(Handle, Handle*);
Call aoti_torch_cpu_gauss_jordan(Handle, Handle*);
Call aoti_torch_cpu_spd_inverse(Handle, Handle*);
Call aoti_torch_cpu_high_power(Handle, int64_t, Handle*);
Call aoti_torch_cpu_sample_patches(Handle, Handle, Handle, Handle, Handle, int64_t, Handle*);
Call aoti_torch_cpu_strongest_extrema(Handle, Handle, int32_t, int64_t, Handle*);
Call aoti_torch_cpu_squared_distances(Handle, Handle, Handle*);
Call aoti_torch_cpu_two_least(Handle, int32_t, Handle*);
Call aoti_torch_cpu_direction_histograms(Handle, Handle, Handle, int64_t, Handle*);
Call aoti_torch_cpu_cumsum(Handle, int64_t, int32_t*, Handle*);
Call aoti_torch_cpu_topk(Handle, int64_t, int64_t, int32_t, int32_t, Handle*, Handle*);
}

namespace kernel_calls {

using Tensor = std::unique_ptr<AtenTensorOpaque>;

/** Where tensors made from now on lie, and how many bytes beside them were written by then: of tensors that are gone. */
extern guarded::Placement placement;
extern int damaged;
/** The text of the last call that failed. */
extern std::string last_error;

Tensor make(const chiasm::artifact::Dims& sizes, int32_t dtype);

template <class T>
constexpr int32_t kCode = -1;
template <> inline constexpr int32_t kCode<uint8_t> = chiasm::artifact::kUint8;
template <> inline constexpr int32_t kCode<bool> = chiasm::artifact::kBool;
template <> inline constexpr int32_t kCode<int32_t> = chiasm::artifact::kInt32;
template <> inline constexpr int32_t kCode<int64_t> = chiasm::artifact::kInt64;
template <> inline constexpr int32_t kCode<float> = chiasm::artifact::kFloat;
template <> inline constexpr int32_t kCode<double> = chiasm::artifact::kDouble;

/** A tensor with values that repeat as often as it takes. */
template <class T>
Tensor of(const chiasm::artifact::Dims& sizes, const std::vector<T>& values) {
  Tensor tensor = make(sizes, kCode<T>);
  auto* const data = reinterpret_cast<T*>(tensor->data());
  for (int64_t i = 0; i < tensor->numel(); ++i) data[i] = values[static_cast<size_t>(i) % values.size()];
  return tensor;
}

template <class T>
Tensor of(const chiasm::artifact::Dims& sizes, std::initializer_list<T> values) { return of(sizes, std::vector<T>(values)); }

}  // namespace kernel_calls
