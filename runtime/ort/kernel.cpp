#include "ort/kernel.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include "backends/onnx/code_in_text.h"
#include "backends/onnx/dtype.h"
#include "base/floats.h"
#include "base/pool.h"
#include "core/signature_text.h"
#include "core/status.h"

namespace chiasm::ort {
namespace {

/** Carries an OrtStatus through our frames as an exception. */
struct OrtError {
  OrtStatus* status;
};

OrtErrorCode code_of(int32_t code) {
  switch (code) {
    case CHIASM_INVALID_ARGUMENT: return ORT_INVALID_ARGUMENT;
    case CHIASM_NOT_FOUND: return ORT_NO_SUCHFILE;
    case CHIASM_UNAVAILABLE: return ORT_NOT_IMPLEMENTED;
    default: return ORT_FAIL;
  }
}

/** Compiled ops allocate memory for each of this many threads before they start them. */
int32_t most_threads() {
  static const auto count =
      static_cast<int32_t>(std::clamp(std::thread::hardware_concurrency(), 1u, unsigned{Team::kMost}));
  return count;
}

native::CompiledOp load(const Node& node) {
  const core::Bytes bytes = node.bundle->read(node.native);
  const std::string signature =
      core::signature_text(node.method, node.bundle->manifest().symbols, node.dtype);
  return native::CompiledOp({bytes.data(), bytes.size(), static_cast<int32_t>(node.method.inputs.size()),
                             static_cast<int32_t>(node.method.outputs.size()), node.method.batched_inputs,
                             node.method.batched_outputs, CHIASM_CPU, 0, signature.c_str()});
}

/** The tensor in a value of ONNX Runtime. */
chiasm_tensor view(const OrtApi& api, const OrtValue& value, int64_t* shape) {
  chiasm_tensor tensor{};
  tensor.struct_size = sizeof tensor;
  tensor.shape = shape;
  OrtTensorTypeAndShapeInfo* raw = nullptr;
  check(api.GetTensorTypeAndShape(&value, &raw));
  const std::unique_ptr<OrtTensorTypeAndShapeInfo, void (*)(OrtTensorTypeAndShapeInfo*)> info(
      raw, api.ReleaseTensorTypeAndShapeInfo);
  ONNXTensorElementDataType type;
  check(api.GetTensorElementType(raw, &type));
  tensor.dtype = onnx::dtype_of(type);
  size_t rank = 0;
  check(api.GetDimensionsCount(raw, &rank));
  if (rank > CHIASM_MAX_DIMS)
    core::fail(CHIASM_INVALID_ARGUMENT, "a tensor has " + std::to_string(rank) + " dimensions");
  check(api.GetDimensions(raw, shape, rank));
  tensor.ndim = static_cast<int32_t>(rank);
  check(api.GetTensorMutableData(const_cast<OrtValue*>(&value), &tensor.data));
  // ONNX Runtime's tensors without elements may have no data, which the core takes for a mistake.
  alignas(64) static char nothing[64];
  if (tensor.data == nullptr && std::find(shape, shape + rank, 0) != shape + rank) tensor.data = nothing;
  return tensor;
}

}  // namespace

void check(OrtStatus* status) {
  if (status != nullptr) throw OrtError{status};
}

OrtStatus* status_from_current_exception(const OrtApi& api) noexcept {
  try {
    throw;
  } catch (const OrtError& error) {
    return error.status;
  } catch (...) {
    // ONNX Runtime passes on the text, not the code: chiasm's own backend reads the code from the text.
    return base::report_current_exception([&api](chiasm_code code, const char* text) {
      char message[2048];
      std::snprintf(message, sizeof message, "%.2000s" CHIASM_CODE_IN_TEXT, text, static_cast<int>(code));
      return api.CreateStatus(code_of(code), message);
    });
  }
}

OrtStatus* Kernel::create(const Node& node, void** kernel) noexcept {
  try {
    *kernel = new Kernel(node);
    return nullptr;
  } catch (...) {
    return status_from_current_exception(node.api);
  }
}

OrtStatus* Kernel::compute(OrtKernelContext* context) noexcept {
  try {
    const base::DefaultFloats floats;
    run(context);
    return nullptr;
  } catch (...) {
    return status_from_current_exception(node_.api);
  }
}

Kernel::Kernel(const Node& node)
    : node_(node),
      signature_(node.method, node.bundle->manifest().symbols, node.dtype, CHIASM_CPU, 0),
      op_(load(node)) {}

void Kernel::run(OrtKernelContext* context) {
  const OrtApi& api = node_.api;
  chiasm_tensor inputs[core::kMaxTensors];
  int64_t shapes[core::kMaxTensors][CHIASM_MAX_DIMS];
  for (size_t i = 0; i < signature_.input_count(); ++i) {
    const OrtValue* value = nullptr;
    check(api.KernelContext_GetInput(context, i, &value));
    inputs[i] = view(api, *value, shapes[i]);
  }
  core::Call call;
  signature_.check_inputs(inputs, signature_.input_count(), call);
  for (size_t i = 0; i < signature_.output_count(); ++i) {
    OrtValue* value = nullptr;
    check(api.KernelContext_GetOutput(context, i, call.outputs[i].shape,
                                      static_cast<size_t>(call.outputs[i].ndim), &value));
    check(api.GetTensorMutableData(value, &call.outputs[i].data));
  }

  struct Work {
    const native::CompiledOp& op;
    const core::Call& call;
    chiasm_native_host host;
    std::exception_ptr error;
    void run() noexcept {
      try {
        op.run(call.inputs, call.outputs, host, host.fork);
      } catch (...) {
        error = std::current_exception();
      }
    }
  } work{op_, call, {}, nullptr};
  work.host.allocate = [](void*, size_t bytes) { return base::Pool::instance().allocate(bytes); };
  work.host.release = [](void*, void* data, size_t bytes) { base::Pool::instance().release(data, bytes); };
  work.host.num_threads = op_.worth_forking(call.inputs, call.outputs) ? most_threads() : 1;
  if (work.host.num_threads == 1) {
    work.run();
  } else {
    Team team(api, context, experience_, work.host.num_threads);
    work.host.context = &team;
    work.host.fork = [](void* t, Team::Body body, void* argument) {
      static_cast<Team*>(t)->fork(body, argument);
    };
    check(team.run([](void* w) { static_cast<Work*>(w)->run(); }, &work));
  }
  if (work.error) std::rethrow_exception(work.error);
}

}  // namespace chiasm::ort
