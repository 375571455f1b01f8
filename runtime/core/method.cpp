// Loads a method on the backend that `choose` selects, and runs it: checks, copies of tensors with gaps, the
// backend's run.
#include "core/method.h"

#include <algorithm>
#include <cstring>
#include <new>

#include "base/cuda.h"
#include "core/gaps.h"
#include "core/status.h"
#include "core/struct_size.h"
#include "core/threads.h"

namespace chiasm::core {
namespace {

/** Throw what a backend reported. */
void check_backend(int32_t code, chiasm_error_text& error, const char* doing, const Backend& backend,
                   const std::string& what) {
  if (code == CHIASM_OK) return;
  error.text[sizeof error.text - 1] = '\0';
  switch (code) {
    case CHIASM_INVALID_ARGUMENT:
    case CHIASM_FAILED_PRECONDITION:
    case CHIASM_NOT_FOUND:
    case CHIASM_CORRUPT:
    case CHIASM_VERSION_MISMATCH:
    case CHIASM_UNTRUSTED:
    case CHIASM_UNAVAILABLE:
    case CHIASM_OUT_OF_MEMORY:
    case CHIASM_IO_ERROR: break;
    default: code = CHIASM_INTERNAL;
  }
  fail(static_cast<chiasm_code>(code),
       std::string(doing) + " " + what + " on the " + backend.name() +
           " backend failed: " + (error.text[0] == '\0' ? "it gave no reason" : error.text));
}

std::vector<int32_t> generic_dtypes(int32_t dtype) {
  return dtype == kGeneric ? std::vector<int32_t>() : std::vector<int32_t>{dtype};
}

}  // namespace

void check_run_options(const chiasm_run_options* options) {
  if (options != nullptr) {
    check_struct_size(options->struct_size, CHIASM_SIZE_THROUGH(chiasm_run_options, stream), "run options",
                      "set it to sizeof(chiasm_run_options)");
  }
}

Outputs::Outputs(Call& call, const std::vector<TensorSpec>& outputs) : slots_(outputs.size()) {
  for (size_t i = 0; i < outputs.size(); ++i) {
    Slot& slot = slots_[i];
    try {
      slot.memory = PooledMemory(call.output_bytes[i]);
    } catch (const std::bad_alloc&) {
      fail(CHIASM_OUT_OF_MEMORY, "output '" + outputs[i].name + "': out of memory: it needs " +
                                     std::to_string(call.output_bytes[i]) + " bytes, its shape is " +
                                     shape_text(call.output_shapes[i], call.outputs[i].ndim));
    }
    call.outputs[i].data = slot.memory.data();
    slot.tensor = call.seen_output(i);
    std::copy_n(slot.tensor.shape, slot.tensor.ndim, slot.shape);
    slot.tensor.shape = slot.shape;
  }
}

std::shared_ptr<Method> Method::load(std::shared_ptr<const Bundle> bundle, const char* name,
                                     const LoadRequest& asked) {
  const LoadRequest request = under(use_trust(), asked);
  const MethodSpec& spec = bundle->method(name);
  const int32_t dtype = choose_dtype(spec, bundle->manifest().dtypes, request);
  const Machine machine = this_machine(request.device_type, request.device_index);
  const auto rank = [&](const Backend& backend, const Artifact& artifact) {
    const LoadCall call(*bundle, spec, artifact, backend, request, dtype);
    return backend.table()->rank == nullptr ? 0 : backend.table()->rank(&call.get());
  };
  std::shared_ptr<Method> method;
  choose(spec, request, dtype, machine, Registry::instance(), rank, [&](const Candidate& candidate) {
    method = std::make_shared<Method>(bundle, spec, *candidate.artifact, *candidate.backend, dtype, request);
  });
  return method;
}

Method::Method(std::shared_ptr<const Bundle> bundle, const MethodSpec& spec, const Artifact& artifact,
               const Backend& backend, int32_t dtype, const LoadRequest& request)
    : bundle_(std::move(bundle)),
      spec_(spec),
      artifact_(artifact),
      backend_(backend),
      device_type_(request.device_type),
      device_index_(request.device_index),
      num_threads_(request.num_threads),
      signature_(spec, bundle_->manifest().symbols, dtype, request.device_type, request.device_index),
      info_(spec, bundle_->manifest().symbols, generic_dtypes(dtype)) {
  load_model(LoadCall(*bundle_, spec, artifact, backend, request, dtype));
  try {
    if (request.warm_up) warm_up();
  } catch (...) {
    backend_.table()->unload(model_);
    throw;
  }
}

Method::~Method() { backend_.table()->unload(model_); }

// The parsed manifest is trusted, and through the hash in it the artifact. The artifact is read once, so that
// the backend gets exactly the bytes that were checked.
void Method::load_model(const LoadCall& call) {
  const Trust& trust = use_trust();
  bundle_->check_trust(trust);
  if (backend_.is_program(artifact_.format) && trust.policy == CHIASM_TRUST_DATA_ONLY) {
    fail(CHIASM_UNTRUSTED, call.path() + " is a program, and the trust policy is 'data_only'");
  }
  const Bytes bytes = bundle_->read(artifact_);
  const chiasm_backend_load load = call.with(bytes);
  chiasm_error_text error;
  error.text[0] = '\0';
  check_backend(backend_.table()->load(&load, &model_, &error), error, "loading", backend_, call.path());
}

void Method::execute(const Call& call, const chiasm_run_options* options) const {
  signature_.check_bools(call);
  chiasm_error_text error;
  error.text[0] = '\0';
  const int32_t code = backend_.table()->run(model_, call.inputs, call.outputs, options, &error);
  if (code != CHIASM_OK) check_backend(code, error, "running", backend_, "'" + spec_.name + "'");
}

std::unique_ptr<Outputs> Method::run(const chiasm_tensor* inputs, size_t count,
                                     const chiasm_run_options* options) const {
  check_run_options(options);
  Call call;
  signature_.check_inputs(inputs, count, call);
  if (device_type_ != CHIASM_CPU) {
    fail(CHIASM_FAILED_PRECONDITION,
         "run allocates its outputs on the CPU only; for a method on CUDA allocate them on the device and "
         "call run_into");
  }
  auto outputs = std::make_unique<Outputs>(call, spec_.outputs);
  const DenseCopies copies(call, inputs, nullptr);
  execute(call, options);
  return outputs;
}

void Method::run_into(const chiasm_tensor* inputs, size_t input_count, const chiasm_tensor* outputs,
                      size_t output_count, const chiasm_run_options* options) const {
  Call call;
  check(inputs, input_count, outputs, output_count, options, call);
  const DenseCopies copies(call, inputs, outputs);
  execute(call, options);
  copies.spread();
}

void Method::check(const chiasm_tensor* inputs, size_t input_count, const chiasm_tensor* outputs,
                   size_t output_count, const chiasm_run_options* options, Call& call) const {
  check_run_options(options);
  signature_.check_inputs(inputs, input_count, call);
  signature_.check_outputs(outputs, output_count, call);
}

size_t Method::runs_at_once() const {
  // On a GPU, runs are enqueued on one stream.
  if (device_type_ != CHIASM_CPU || num_threads_ == 0) return 1;
  return static_cast<size_t>(std::max(use_num_threads() / num_threads_, 1));
}

void Method::warm_up() const {
  Call call;
  int64_t shapes[kMaxTensors][CHIASM_MAX_DIMS];
  signature_.smallest_call(call, shapes);
  std::vector<PooledMemory> host;
  std::vector<CudaBuffer> device;
  const auto supply = [&](chiasm_tensor& tensor) {
    const size_t bytes = Signature::bytes_of(tensor, "tensor", "of the warm-up");
    try {
      host.emplace_back(bytes);
    } catch (const std::bad_alloc&) {
      fail(CHIASM_OUT_OF_MEMORY, "the warm-up of '" + spec_.name + "': out of memory: a tensor of it needs " +
                                     std::to_string(bytes) + " bytes");
    }
    tensor.data = host.back().data();
    std::memset(tensor.data, 0, bytes);
    if (device_type_ == CHIASM_CPU) return;
    device.emplace_back(device_index_, bytes);
    device.back().copy_from_host(tensor.data, bytes);
    tensor.data = device.back().data();
  };
  for (size_t i = 0; i < signature_.input_count(); ++i) supply(call.inputs[i]);
  for (size_t i = 0; i < signature_.output_count(); ++i) supply(call.outputs[i]);
  execute(call, nullptr);
  // Wait for the GPU: the buffers are about to be freed.
  if (!device.empty()) device.back().copy_to_host(host.back().data(), 1);
}

}  // namespace chiasm::core
