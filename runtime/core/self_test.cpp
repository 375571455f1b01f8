// Loads each artifact of a bundle, runs it on the golden inputs and compares its outputs with the golden
// ones.
#include "core/self_test.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <new>

#include "base/cuda.h"
#include "base/dtype.h"
#include "base/pool.h"
#include "core/golden.h"
#include "core/method.h"
#include "core/safetensors.h"
#include "core/status.h"

namespace chiasm::core {
namespace {

using Stored = std::map<std::string, StoredTensor>;

/** The result of a row, and its message. */
struct Row {
  int32_t passed = -1;
  double max_error = 0, tolerance = 0;
  std::string message;
};

const StoredTensor& find(const Stored& stored, const std::string& prefix, const std::string& name,
                         const std::string& file) {
  const auto found = stored.find(prefix + "/" + name);
  if (found == stored.end())
    fail(CHIASM_CORRUPT, file + ": there is no tensor '" + prefix + "/" + name + "'");
  return found->second;
}

/** Memory where the method runs. */
class Buffer final {
 public:
  Buffer(const LoadRequest& request, size_t bytes) : bytes_(bytes), host_(bytes) {
    if (request.device_type == CHIASM_CUDA) device_ = CudaBuffer(request.device_index, bytes);
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  void* data() const { return device_.data() != nullptr ? device_.data() : host_.data(); }
  void write(const void* source) {
    if (bytes_ > 0) std::memcpy(host_.data(), source, bytes_);
    if (device_.data() != nullptr) device_.copy_from_host(host_.data(), bytes_);
  }
  const void* read() {
    if (device_.data() != nullptr) device_.copy_to_host(host_.data(), bytes_);
    return host_.data();
  }

 private:
  size_t bytes_;
  PooledMemory host_;
  CudaBuffer device_;
};

chiasm_tensor view(const StoredTensor& stored, void* data, const LoadRequest& request) {
  return {sizeof(chiasm_tensor), data,
          stored.dtype,          request.device_type,
          request.device_index,  static_cast<int32_t>(stored.shape.size()),
          stored.shape.data(),   nullptr};
}

/** With the digits that tell a float32 from all others. */
std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

/** Run one case and compare; throws Error if it cannot be run. */
void replay(const Method& method, const MethodSpec& spec, const GoldenCase& one, const Stored& stored,
            const LoadRequest& request, const std::string& file, Row& row) {
  std::vector<std::unique_ptr<Buffer>> buffers;
  const auto supply = [&](const StoredTensor& tensor) {
    buffers.push_back(std::make_unique<Buffer>(request, tensor.size));
    return view(tensor, buffers.back()->data(), request);
  };
  std::vector<chiasm_tensor> inputs, outputs;
  for (const TensorSpec& tensor : spec.inputs) {
    const StoredTensor& golden = find(stored, one.prefix, tensor.name, file);
    inputs.push_back(supply(golden));
    buffers.back()->write(golden.data);
  }
  for (const TensorSpec& tensor : spec.outputs)
    outputs.push_back(supply(find(stored, one.prefix, tensor.name, file)));
  method.run_into(inputs.data(), inputs.size(), outputs.data(), outputs.size(), nullptr);

  row.passed = 1;
  for (size_t i = 0; i < outputs.size(); ++i) {
    const StoredTensor& golden = find(stored, one.prefix, spec.outputs[i].name, file);
    const Tolerance tolerance = spec.tolerances[static_cast<size_t>(golden.dtype)].value_or(Tolerance{});
    const size_t count = golden.size / kDTypes[golden.dtype].size;
    const Comparison result =
        compare(buffers[inputs.size() + i]->read(), golden.data, count, golden.dtype, tolerance);
    row.max_error = std::max(row.max_error, result.max_error);
    row.tolerance = std::max(row.tolerance, tolerance.atol);
    if (result.passed) continue;
    row.passed = 0;
    row.message += (row.message.empty() ? "" : "; ") + ("output '" + spec.outputs[i].name + "': ") +
                   std::to_string(result.mismatches) + " of " + std::to_string(count) +
                   " values differ, the worst at element " + std::to_string(result.worst) + ": " +
                   text_of(result.actual) + ", golden " + text_of(result.expected);
  }
}

/** Why the artifact is not tried, or "". */
std::string obstacle(const Artifact& artifact, const LoadRequest& request, int32_t dtype,
                     const Machine& machine, Registry& registry) {
  const std::string why = incompatibility(artifact, request, dtype, machine);
  if (!why.empty()) return "the artifact " + why;
  const Backend* const backend = registry.find(artifact.backend);
  if (backend == nullptr) return registry.not_found(artifact.backend);
  if (backend->table() == nullptr) return backend->engine().problem;
  if (!backend->loads(artifact.format))
    return "the " + artifact.backend + " backend does not load format '" + artifact.format + "'";
  const std::string refused = request.programs_refused();
  if (backend->is_program(artifact.format) && !refused.empty())
    return "the artifact is a program, and " + refused;
  if (!backend->has_device(request.device_type))
    return "the " + artifact.backend + " backend does not run on this kind of device";
  const Backend::Engine& engine = backend->engine();
  if (!engine.problem.empty()) return engine.problem;
  if (request.device_type == CHIASM_CUDA && !engine.has_cuda) {
    return "the engine (" + engine.version + ") cannot use CUDA here";
  }
  return "";
}

}  // namespace

int32_t self_test(const std::shared_ptr<const Bundle>& bundle, const LoadRequest& asked, Registry& registry,
                  chiasm_self_test_callback callback, void* user) {
  const LoadRequest request = under(use_trust(), asked);
  const Manifest& manifest = bundle->manifest();
  const Machine machine = this_machine(request.device_type, request.device_index);
  const std::string file = bundle->file_path(manifest.golden.file);
  const auto has_its = [&request](const MethodSpec& spec) {
    return std::any_of(spec.artifacts.begin(), spec.artifacts.end(),
                       [&request](const Artifact& artifact) { return artifact.backend == request.backend; });
  };
  // A backend that has artifacts but is not installed gets rows that say so
  if (!request.backend.empty() && std::none_of(manifest.methods.begin(), manifest.methods.end(), has_its) &&
      registry.find(request.backend) == nullptr) {
    fail(CHIASM_UNAVAILABLE, registry.not_found(request.backend));
  }
  bundle->check_trust(use_trust());
  const Bytes bytes = bundle->read(manifest.golden);
  const Stored stored = read_safetensors(bytes.data(), bytes.size(), file);

  int32_t failed = 0;
  for (const MethodSpec& spec : manifest.methods) {
    for (const Artifact& artifact : spec.artifacts) {
      if (!request.backend.empty() && request.backend != artifact.backend) continue;
      // One load serves all cases of a dtype.
      std::unique_ptr<Method> method;
      int32_t loaded_dtype = kGeneric;
      for (const GoldenCase& one : manifest.golden_cases) {
        if (&manifest.methods[one.method] != &spec) continue;
        if (request.dtype != kGeneric && spec.generic && one.dtype != request.dtype) continue;
        const int32_t dtype = spec.generic ? one.dtype : kGeneric;
        const auto& served = artifact.dtypes;
        if (spec.generic && std::find(served.begin(), served.end(), dtype) == served.end()) continue;
        Row row;
        row.message = obstacle(artifact, request, dtype, machine, registry);
        if (row.message.empty()) {
          try {
            if (method == nullptr || loaded_dtype != dtype) {
              method = std::make_unique<Method>(bundle, spec, artifact, *registry.find(artifact.backend),
                                                dtype, request);
              loaded_dtype = dtype;
            }
            replay(*method, spec, one, stored, request, file, row);
          } catch (const Error& error) {
            const bool not_here =
                error.code() == CHIASM_UNAVAILABLE || error.code() == CHIASM_VERSION_MISMATCH;
            row.passed = not_here ? -1 : 0;  // as for an artifact with an obstacle
            row.message = error.what();
          } catch (const std::exception& error) {
            row.passed = 0;
            row.message = error.what();
          }
        }
        if (row.passed == 0) ++failed;
        if (callback == nullptr) continue;
        const chiasm_self_test_row shown{sizeof(chiasm_self_test_row),
                                         spec.name.c_str(),
                                         artifact.backend.c_str(),
                                         artifact.file.c_str(),
                                         one.dtype == kGeneric ? "" : dtype_name(one.dtype),
                                         row.passed,
                                         row.max_error,
                                         row.tolerance,
                                         row.message.c_str()};
        callback(&shown, user);
      }
    }
  }
  return failed;
}

}  // namespace chiasm::core
