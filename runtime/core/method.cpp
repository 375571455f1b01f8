#include "core/method.h"

#include <cstring>
#include <new>

#include "core/cuda.h"
#include "core/onnx_file.h"
#include "core/signature_text.h"
#include "core/status.h"
#include "core/threads.h"

namespace chiasm::core {
namespace {

/** Throw what a backend reported. */
void check_backend(int32_t code, chiasm_error_text& error, const char* doing, const Backend& backend, const std::string& what) {
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
  fail(static_cast<chiasm_code>(code), std::string(doing) + " " + what + " on the " + backend.name() + " backend failed: " +
                                           (error.text[0] == '\0' ? "it gave no reason" : error.text));
}

std::vector<const char*> names_of(const std::vector<TensorSpec>& tensors) {
  std::vector<const char*> names;
  for (const TensorSpec& tensor : tensors) names.push_back(tensor.name.c_str());
  return names;
}

std::vector<int32_t> generic_dtypes(int32_t dtype) {
  return dtype == kGeneric ? std::vector<int32_t>() : std::vector<int32_t>{dtype};
}

void check_run_options(const chiasm_run_options* options) {
  if (options != nullptr && options->struct_size < sizeof(chiasm_run_options)) {
    fail(CHIASM_INVALID_ARGUMENT, "run options: struct_size is " + std::to_string(options->struct_size) +
                                      ", expected sizeof(chiasm_run_options), " + std::to_string(sizeof(chiasm_run_options)));
  }
}

}  // namespace

Outputs::Outputs(Call& call, const std::vector<TensorSpec>& outputs) : slots_(outputs.size()) {
  for (size_t i = 0; i < outputs.size(); ++i) {
    Slot& slot = slots_[i];
    try {
      slot.block = BufferPool::instance().take(call.output_bytes[i]);
    } catch (const std::bad_alloc&) {
      for (Slot& taken : slots_) BufferPool::instance().give(taken.block);
      fail(CHIASM_OUT_OF_MEMORY, "output '" + outputs[i].name + "': out of memory: it needs " + std::to_string(call.output_bytes[i]) +
                                     " bytes, its shape is " + shape_text(call.output_shapes[i], call.outputs[i].ndim));
    }
    std::memcpy(slot.shape, call.output_shapes[i], sizeof slot.shape);
    call.outputs[i].data = slot.block.data;
    slot.tensor = call.outputs[i];
    slot.tensor.shape = slot.shape;
  }
}

Outputs::~Outputs() {
  for (Slot& slot : slots_) BufferPool::instance().give(slot.block);
}

std::shared_ptr<Method> Method::load(std::shared_ptr<const Bundle> bundle, const char* name, const LoadRequest& asked) {
  const LoadRequest request = under(use_trust(), asked);
  const MethodSpec& spec = bundle->method(name);
  const int32_t dtype = choose_dtype(spec, bundle->manifest().dtypes, request);
  const Machine machine = this_machine(request.device_type, request.device_index);
  const Choice choice = choose(spec, request, dtype, machine, Registry::instance());
  if (const Artifact* fused = fused_form(spec, *choice.artifact, request, dtype, machine)) {
    try {
      return std::make_shared<Method>(bundle, spec, *fused, *choice.backend, dtype, request);
    } catch (const Error& error) {
      if (error.code() != CHIASM_UNAVAILABLE) throw;  // else libchiasm_ort is not installed: the standard operators do as well
    }
  }
  return std::make_shared<Method>(std::move(bundle), spec, *choice.artifact, *choice.backend, dtype, request);
}

Method::Method(std::shared_ptr<const Bundle> bundle, const MethodSpec& spec, const Artifact& artifact, const Backend& backend,
               int32_t dtype, const LoadRequest& request)
    : bundle_(std::move(bundle)),
      spec_(spec),
      artifact_(artifact),
      backend_(backend),
      device_type_(request.device_type),
      device_index_(request.device_index),
      dtype_(dtype),
      signature_(spec, bundle_->manifest().symbols, dtype, request.device_type, request.device_index),
      info_(spec, bundle_->manifest().symbols, generic_dtypes(dtype)) {
  load_model(request);
  try {
    if (request.warm_up) warm_up();
  } catch (...) {
    backend_.table->unload(model_);
    throw;
  }
}

Method::~Method() { backend_.table->unload(model_); }

// What is trusted is the manifest that was parsed, and by its hash the artifact's bytes, which are read once: those that are checked
// here are those that the backend gets.
void Method::load_model(const LoadRequest& request) {
  const std::string path = bundle_->file_path(artifact_.file);
  const Trust& trust = use_trust();
  bundle_->check_trust(trust);
  if (is_program(artifact_) && trust.policy == CHIASM_TRUST_DATA_ONLY) {
    fail(CHIASM_UNTRUSTED, path + " is a program, and the trust policy is 'data_only'");
  }
  const Bytes bytes = bundle_->read(artifact_);
  if (artifact_.backend == BackendKind::onnx) check_onnx(bytes.data(), bytes.size(), path);
  const std::vector<const char*> inputs = names_of(spec_.inputs), outputs = names_of(spec_.outputs);
  chiasm_backend_load load{};
  load.struct_size = sizeof load;
  load.data = bytes.data();
  load.size = bytes.size();
  load.file = path.c_str();
  load.format = artifact_.format.c_str();
  load.device_type = request.device_type;
  load.device_index = request.device_index;
  load.num_threads = use_num_threads();
  load.autograd = artifact_.autograd ? 1 : 0;
  load.input_count = static_cast<int32_t>(inputs.size());
  load.output_count = static_cast<int32_t>(outputs.size());
  load.input_names = inputs.data();
  load.output_names = outputs.data();
  load.sample_inputs = spec_.sample_inputs;
  load.sample_outputs = spec_.sample_outputs;
  const std::string signature = signature_text(spec_, bundle_->manifest().symbols, dtype_);
  load.signature = signature.c_str();
  if (!artifact_.function.empty()) {
    load.function = artifact_.function.c_str();
    load.bundle = bundle_->info().path;
    load.manifest_sha256 = bundle_->manifest_sha256().c_str();
  }
  chiasm_error_text error;
  error.text[0] = '\0';
  check_backend(backend_.table->load(&load, &model_, &error), error, "loading", backend_, path);
}

void Method::execute(const Call& call, const chiasm_run_options* options) const {
  chiasm_error_text error;
  error.text[0] = '\0';
  const int32_t code = backend_.table->run(model_, call.inputs, call.outputs, options, &error);
  if (code != CHIASM_OK) check_backend(code, error, "running", backend_, "'" + spec_.name + "'");
}

std::unique_ptr<Outputs> Method::run(const chiasm_tensor* inputs, size_t count, const chiasm_run_options* options) const {
  check_run_options(options);
  Call call;
  signature_.check_inputs(inputs, count, call);
  if (device_type_ != CHIASM_CPU) {
    fail(CHIASM_FAILED_PRECONDITION,
         "run allocates its outputs on the CPU only; for a method on CUDA allocate them on the device and call run_into");
  }
  auto outputs = std::make_unique<Outputs>(call, spec_.outputs);
  execute(call, options);
  return outputs;
}

void Method::run_into(const chiasm_tensor* inputs, size_t input_count, const chiasm_tensor* outputs, size_t output_count,
                      const chiasm_run_options* options) const {
  check_run_options(options);
  Call call;
  signature_.check_inputs(inputs, input_count, call);
  signature_.check_outputs(outputs, output_count, call);
  execute(call, options);
}

void Method::warm_up() const {
  Call call;
  int64_t shapes[kMaxTensors][CHIASM_MAX_DIMS];
  signature_.smallest_call(call, shapes);
  struct Host {
    std::vector<BufferPool::Block> blocks;
    ~Host() {
      for (const BufferPool::Block& block : blocks) BufferPool::instance().give(block);
    }
  } host;
  std::vector<CudaBuffer> device;
  const auto supply = [&](chiasm_tensor& tensor) {
    const size_t bytes = Signature::bytes_of(tensor, "tensor", "of the warm-up");
    try {
      host.blocks.push_back(BufferPool::instance().take(bytes));
    } catch (const std::bad_alloc&) {
      fail(CHIASM_OUT_OF_MEMORY, "the warm-up of '" + spec_.name + "': out of memory: a tensor of it needs " + std::to_string(bytes) + " bytes");
    }
    tensor.data = host.blocks.back().data;
    std::memset(tensor.data, 0, bytes);
    if (device_type_ == CHIASM_CPU) return;
    device.emplace_back(device_index_, bytes);
    device.back().copy_from_host(tensor.data, bytes);
    tensor.data = device.back().data();
  };
  for (size_t i = 0; i < signature_.input_count(); ++i) supply(call.inputs[i]);
  for (size_t i = 0; i < signature_.output_count(); ++i) supply(call.outputs[i]);
  execute(call, nullptr);
  // Wait: the buffers are about to go.
  if (!device.empty()) device.back().copy_to_host(host.blocks.back().data, 1);
}

}  // namespace chiasm::core
