/** A chiasm method as an operator of ONNX Runtime. */
#pragma once

#include <onnxruntime_c_api.h>

#include <memory>
#include <string>
#include <vector>

#include "core/bundle.h"
#include "core/select.h"

namespace chiasm::ort {

/** The operator `chiasm::<function>` for one value of T: what ONNX Runtime asks before it makes kernels.
 *  Never freed: nothing tells us when the last session that uses it ends. */
struct Node final : OrtCustomOp {
  Node(const OrtApi& api, std::shared_ptr<const core::Bundle> bundle, const core::MethodSpec& method,
       const core::Artifact& native, std::string function, int32_t dtype);

  const OrtApi& api;
  const std::shared_ptr<const core::Bundle> bundle;
  const core::MethodSpec& method;
  const core::Artifact& native; /**< what the kernel runs */
  const std::string function;
  const int32_t dtype; /**< what T stands for */
  const int version;   /**< of the operator: the bundle's major version, but 1 before 1.0 */
};

/** The operators of a bundle's methods that have native code for this machine, if the request allows it. For
 *  any other method ONNX Runtime runs the function's body, and `report` gets a line that says so. */
std::vector<std::unique_ptr<Node>> nodes_of(const OrtApi& api,
                                            const std::shared_ptr<const core::Bundle>& bundle,
                                            const core::LoadRequest& request, std::string& report);

}  // namespace chiasm::ort
