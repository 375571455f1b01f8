#include "ort/node.h"

#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <utility>

#include "backends/onnx/dtype.h"
#include "base/dtype.h"
#include "core/select.h"
#include "core/status.h"
#include "ort/kernel.h"

namespace chiasm::ort {
namespace {

/** The version of ONNX Runtime's interface for which OrtCustomOp is filled in. Every version from 1.17 on
 *  reads it. */
constexpr uint32_t kInterface = 17;

const Node& self(const OrtCustomOp* op) { return *static_cast<const Node*>(op); }

ONNXTensorElementDataType type_of(const core::TensorSpec& tensor, const Node& node) {
  return onnx::element_type(tensor.dtype == core::kGeneric ? node.dtype : tensor.dtype);
}

bool is_there(const std::string& path) {
  struct stat info {};
  return ::stat(path.c_str(), &info) == 0;
}

}  // namespace

Node::Node(const OrtApi& the_api, std::shared_ptr<const core::Bundle> the_bundle,
           const core::MethodSpec& the_method, const core::Artifact& the_native, std::string the_function,
           int32_t the_dtype)
    : OrtCustomOp{},
      api(the_api),
      bundle(std::move(the_bundle)),
      method(the_method),
      native(the_native),
      function(std::move(the_function)),
      dtype(the_dtype),
      version(std::max(1, std::atoi(bundle->manifest().version.c_str()))) {
  OrtCustomOp& op = *this;
  op.version = kInterface;
  op.GetName = [](const OrtCustomOp* o) { return self(o).function.c_str(); };
  op.GetExecutionProviderType = [](const OrtCustomOp*) -> const char* { return nullptr; };  // the CPU's
  op.GetInputTypeCount = [](const OrtCustomOp* o) { return self(o).method.inputs.size(); };
  op.GetInputType = [](const OrtCustomOp* o, size_t i) { return type_of(self(o).method.inputs[i], self(o)); };
  op.GetOutputTypeCount = [](const OrtCustomOp* o) { return self(o).method.outputs.size(); };
  op.GetOutputType = [](const OrtCustomOp* o, size_t i) {
    return type_of(self(o).method.outputs[i], self(o));
  };
  op.GetInputCharacteristic = [](const OrtCustomOp*, size_t) { return INPUT_OUTPUT_REQUIRED; };
  op.GetOutputCharacteristic = [](const OrtCustomOp*, size_t) { return INPUT_OUTPUT_REQUIRED; };
  op.GetInputMemoryType = [](const OrtCustomOp*, size_t) { return OrtMemTypeDefault; };
  op.GetVariadicInputMinArity = [](const OrtCustomOp*) { return 1; };
  op.GetVariadicInputHomogeneity = [](const OrtCustomOp*) { return 1; };
  op.GetVariadicOutputMinArity = [](const OrtCustomOp*) { return 1; };
  op.GetVariadicOutputHomogeneity = [](const OrtCustomOp*) { return 1; };
  op.GetStartVersion = [](const OrtCustomOp* o) { return self(o).version; };
  op.GetEndVersion = [](const OrtCustomOp* o) { return self(o).version; };
  op.CreateKernelV2 = [](const OrtCustomOp* o, const OrtApi*, const OrtKernelInfo*, void** kernel) {
    return Kernel::create(self(o), kernel);
  };
  op.KernelComputeV2 = [](void* kernel, OrtKernelContext* context) {
    return static_cast<Kernel*>(kernel)->compute(context);
  };
  op.KernelDestroy = [](void* kernel) { delete static_cast<Kernel*>(kernel); };
}

std::vector<std::unique_ptr<Node>> nodes_of(const OrtApi& api,
                                            const std::shared_ptr<const core::Bundle>& bundle,
                                            const core::LoadRequest& request, std::string& report) {
  const core::Machine machine = core::this_machine(CHIASM_CPU, 0);
  std::vector<std::unique_ptr<Node>> nodes;
  for (const core::MethodSpec& method : bundle->manifest().methods) {
    // Register all of a function's dtypes or none: if an operator has the function's name, ONNX Runtime drops
    // the body, whatever the dtype.
    std::vector<std::unique_ptr<Node>> made;
    std::string why_not = request.programs_refused();
    for (const core::Artifact& fused : method.artifacts) {
      const std::string function = fused.option("function");
      if (function.empty()) continue;
      const std::vector<int32_t> dtypes =
          method.generic ? fused.dtypes : std::vector<int32_t>{core::kGeneric};
      for (const int32_t dtype : dtypes) {
        std::string incompatibilities;
        const core::Artifact* native =
            core::best_fit(method, "native", request, dtype, machine, incompatibilities);
        if (native == nullptr) {
          why_not = incompatibilities;
        } else if (!is_there(bundle->file_path(native->file))) {
          why_not = native->file + " is missing";
        } else {
          made.push_back(std::make_unique<Node>(api, bundle, method, *native, function, dtype));
        }
      }
    }
    if (why_not.empty()) {
      std::move(made.begin(), made.end(), std::back_inserter(nodes));
    } else {
      report += "chiasm: '" + method.name + "' of " + bundle->info().path +
                " runs as standard operators: native: " + why_not + "\n";
    }
  }
  return nodes;
}

}  // namespace chiasm::ort
