// Fills the C structs of a method's signature with pointers into the manifest.
#include "core/info.h"

namespace chiasm::core {

MethodInfo::MethodInfo(const MethodSpec& method, const std::vector<Symbol>& symbols,
                       std::vector<int32_t> dtypes)
    : dtypes_(std::move(dtypes)) {
  tensors_.reserve(method.inputs.size() + method.outputs.size());
  for (const TensorSpec& spec : method.inputs) add(spec, symbols);
  for (const TensorSpec& spec : method.outputs) add(spec, symbols);
  info_.struct_size = sizeof info_;
  info_.name = method.name.c_str();
  info_.input_count = static_cast<int32_t>(method.inputs.size());
  info_.output_count = static_cast<int32_t>(method.outputs.size());
  info_.inputs = tensors_.data();
  info_.outputs = tensors_.data() + method.inputs.size();
}

void MethodInfo::add(const TensorSpec& spec, const std::vector<Symbol>& symbols) {
  std::vector<chiasm_dim_info> dims;
  for (const Expression& dim : spec.shape) {
    chiasm_dim_info info{sizeof(chiasm_dim_info), dim.text().c_str(), 0, 0};
    if (dim.is_constant()) {
      info.min = info.max = dim.operand();
    } else if (dim.is_symbol()) {
      info.min = symbols[static_cast<size_t>(dim.operand())].min;
      info.max = symbols[static_cast<size_t>(dim.operand())].max;
    }
    dims.push_back(info);
  }
  dims_.push_back(std::move(dims));
  chiasm_tensor_info info{};
  info.struct_size = sizeof info;
  info.name = spec.name.c_str();
  info.description = spec.description.c_str();
  info.layout = spec.layout.c_str();
  info.color = spec.color.c_str();
  info.dtypes = spec.dtype == kGeneric ? dtypes_.data() : &spec.dtype;
  info.dtype_count = spec.dtype == kGeneric ? static_cast<int32_t>(dtypes_.size()) : 1;
  info.ndim = static_cast<int32_t>(spec.shape.size());
  info.dims = dims_.back().data();
  info.value_min = spec.value_min;
  info.value_max = spec.value_max;
  tensors_.push_back(info);
}

}  // namespace chiasm::core
