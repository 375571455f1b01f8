/** A model of the repository: a method of the one bundle in its version's folder. */
#pragma once

#include <triton/core/tritonbackend.h>

#include <memory>
#include <string>

#include "chiasm/chiasm.hpp"
#include "triton/config.h"

namespace chiasm::triton {

struct DeleteMetric {
  void operator()(TRITONSERVER_Metric* metric) const noexcept;
};
struct DeleteFamily {
  void operator()(TRITONSERVER_MetricFamily* family) const noexcept;
};
using Metric = std::unique_ptr<TRITONSERVER_Metric, DeleteMetric>;
using MetricFamily = std::unique_ptr<TRITONSERVER_MetricFamily, DeleteFamily>;

/** chiasm_model_info; none if the server has no metrics. */
MetricFamily make_metric_family();

class Model final {
 public:
  /** Opens the bundle, loads the method, and completes or checks the configuration. Throws Failure or
   *  Error. */
  Model(TRITONBACKEND_Model* model, TRITONSERVER_MetricFamily* family);

  const Method& method() const { return method_; }
  const Signature& signature() const { return signature_; }

 private:
  Parameters parameters_;
  Bundle bundle_;
  Method method_;
  Signature signature_;
  Metric metric_;
};

}  // namespace chiasm::triton
