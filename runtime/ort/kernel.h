/** The kernel of a model's node `chiasm::<function>`. */
#pragma once

#include <onnxruntime_c_api.h>

#include "backends/native/compiled_op.h"
#include "core/signature.h"
#include "ort/node.h"
#include "ort/team.h"

namespace chiasm::ort {

/** One node of one session. `compute` may be called from several threads at once. */
class Kernel final {
 public:
  /** Loads the native artifact. No exception leaves this class: errors become statuses. */
  static OrtStatus* create(const Node& node, void** kernel) noexcept;
  OrtStatus* compute(OrtKernelContext* context) noexcept;

 private:
  explicit Kernel(const Node& node);
  void run(OrtKernelContext* context);

  const Node& node_;
  const core::Signature signature_;
  const native::CompiledOp op_;
  Team::Experience experience_{0};
};

/** Throws what a function of ONNX Runtime reported; status_from_current_exception hands it back as it is. */
void check(OrtStatus* status);

/** A status for the exception that is being handled. */
OrtStatus* status_from_current_exception(const OrtApi& api) noexcept;

}  // namespace chiasm::ort
