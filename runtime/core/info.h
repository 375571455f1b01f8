/** Signatures as the C interface shows them. */
#pragma once

#include <vector>

#include "core/manifest.h"

namespace chiasm::core {

/** Owns the arrays behind one chiasm_method_info. The specs must outlive it. */
class MethodInfo final {
 public:
  /** `dtypes`: what T stands for. */
  MethodInfo(const MethodSpec& method, const std::vector<Symbol>& symbols, std::vector<int32_t> dtypes);
  MethodInfo(MethodInfo&&) = default;
  MethodInfo(const MethodInfo&) = delete;
  MethodInfo& operator=(const MethodInfo&) = delete;

  const chiasm_method_info& get() const { return info_; }

 private:
  void add(const TensorSpec& spec, const std::vector<Symbol>& symbols);

  std::vector<int32_t> dtypes_;
  std::vector<chiasm_tensor_info> tensors_; /**< inputs, then outputs */
  std::vector<std::vector<chiasm_dim_info>> dims_;
  chiasm_method_info info_{};
};

}  // namespace chiasm::core
