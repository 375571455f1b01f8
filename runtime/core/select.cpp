#include "core/select.h"

#include <algorithm>

#include "core/cpu.h"
#include "core/cuda.h"
#include "core/dtype.h"
#include "core/status.h"

namespace chiasm::core {

LoadRequest read_load_options(const chiasm_load_options* options) {
  LoadRequest request;
  if (options == nullptr) return request;
  if (options->struct_size < sizeof(chiasm_load_options)) {
    fail(CHIASM_INVALID_ARGUMENT, "load options: struct_size is " + std::to_string(options->struct_size) +
                                      ": start from CHIASM_LOAD_OPTIONS_INIT");
  }
  if (options->backend != nullptr && std::string(options->backend) != "auto") {
    for (int32_t i = 0; i < kBackendCount; ++i) {
      if (std::string(options->backend) == kBackendNames[i]) request.backend = static_cast<BackendKind>(i);
    }
    if (!request.backend) {
      fail(CHIASM_INVALID_ARGUMENT,
           "load options: unknown backend '" + std::string(options->backend) + "', expected native, torch, onnx or auto");
    }
  }
  if (options->device_type != CHIASM_CPU && options->device_type != CHIASM_CUDA) {
    fail(CHIASM_INVALID_ARGUMENT, "load options: unknown device_type " + std::to_string(options->device_type));
  }
  if (options->device_index < 0 || (options->device_type == CHIASM_CPU && options->device_index != 0)) {
    fail(CHIASM_INVALID_ARGUMENT, "load options: device_index is " + std::to_string(options->device_index) +
                                      (options->device_type == CHIASM_CPU ? ", expected 0 for the CPU" : ""));
  }
  if (options->dtype < -1 || options->dtype >= kDTypeCount) {
    fail(CHIASM_INVALID_ARGUMENT, "load options: unknown dtype " + std::to_string(options->dtype));
  }
  request.device_type = options->device_type;
  request.device_index = options->device_index;
  request.allow_native_code = options->allow_native_code != 0;
  request.dtype = options->dtype;
  request.fused = options->fused != 0;
  request.warm_up = options->warm_up != 0;
  return request;
}

LoadRequest under(const Trust& trust, LoadRequest request) {
  request.data_only = trust.policy == CHIASM_TRUST_DATA_ONLY;
  return request;
}

std::string LoadRequest::programs_refused() const {
  return data_only            ? "the trust policy is 'data_only'"
         : !allow_native_code ? "allow_native_code is 0"
                              : "";
}

Machine this_machine(int32_t device_type, int32_t device_index) {
  Machine machine;
  machine.isa = cpu_supports(Isa::x86_64_v4)   ? Isa::x86_64_v4
                : cpu_supports(Isa::x86_64_v3) ? Isa::x86_64_v3
                                               : Isa::none;
  if (device_type == CHIASM_CUDA) machine.sm = cuda_compute_capability(device_index);
  return machine;
}

int32_t choose_dtype(const MethodSpec& method, const std::vector<int32_t>& dtypes, const LoadRequest& request) {
  if (!method.generic) return kGeneric;
  const int32_t asked = request.dtype;
  std::vector<int32_t> offered;
  for (const int32_t dtype : dtypes) {
    for (const Artifact& artifact : method.artifacts) {
      const bool wanted = !request.backend || *request.backend == artifact.backend;
      if (!wanted || std::find(artifact.dtypes.begin(), artifact.dtypes.end(), dtype) == artifact.dtypes.end()) continue;
      offered.push_back(dtype);
      break;
    }
  }
  if (offered.empty()) offered = dtypes;  // no artifact at all for that backend: `choose` says so
  const auto has = [&offered](int32_t dtype) { return std::find(offered.begin(), offered.end(), dtype) != offered.end(); };
  if (asked == kGeneric) return has(CHIASM_FLOAT32) ? CHIASM_FLOAT32 : offered.front();
  if (!has(asked)) {
    std::string all;
    for (const int32_t dtype : offered) all += (all.empty() ? "" : ", ") + std::string(dtype_name(dtype));
    fail(CHIASM_NOT_FOUND, "method '" + method.name + "' has no artifact for " + dtype_name(asked) + "; it has " + all);
  }
  return asked;
}

std::string misfit(const Artifact& artifact, const LoadRequest& request, int32_t dtype, const Machine& machine) {
  if (dtype != kGeneric && std::find(artifact.dtypes.begin(), artifact.dtypes.end(), dtype) == artifact.dtypes.end()) {
    return std::string("is not for ") + dtype_name(dtype);
  }
  const bool cuda = request.device_type == CHIASM_CUDA;
  if (cuda && artifact.device == DevicePlacement::cpu) return "is for the CPU";
  if (!cuda && artifact.device == DevicePlacement::cuda) return "is for CUDA";
  if (cuda && artifact.sm != 0) {
    // Code for 9.0 runs on 9.x, but neither on 8.x nor on 10.x.
    if (machine.sm / 10 != artifact.sm / 10 || machine.sm < artifact.sm) {
      return "is for a GPU of compute capability " + std::to_string(artifact.sm) + ", this one has " + std::to_string(machine.sm);
    }
  }
  if (!cuda && artifact.isa > machine.isa) return std::string("needs a CPU with ") + kIsaNames[static_cast<int>(artifact.isa)];
  return "";
}

namespace {

/** Why the method has compiled code, but none for the native backend; "" where it has no compiled code. */
std::string needs_of(const MethodSpec& method) {
  for (const Artifact& artifact : method.artifacts) {
    if (artifact.needs_libtorch) return artifact.file + " needs libtorch" + (artifact.why.empty() ? "" : ": " + artifact.why);
  }
  return "";
}

}  // namespace

const Artifact* best_fit(const MethodSpec& method, BackendKind kind, const LoadRequest& request, int32_t dtype,
                         const Machine& machine, std::string& why_not) {
  const Artifact* best = nullptr;
  for (const Artifact& artifact : method.artifacts) {
    if (artifact.backend != kind || !artifact.function.empty()) continue;
    const std::string why = misfit(artifact, request, dtype, machine);
    if (why.empty()) {
      if (best == nullptr || artifact.isa > best->isa || artifact.sm > best->sm) best = &artifact;
    } else {
      why_not += (why_not.empty() ? "" : ", ") + artifact.file + " " + why;
    }
  }
  if (best == nullptr && why_not.empty() && kind == BackendKind::native) why_not = needs_of(method);
  if (best == nullptr && why_not.empty()) why_not = "the bundle has no artifact for it";
  return best;
}

const Artifact* fused_form(const MethodSpec& method, const Artifact& flat, const LoadRequest& request, int32_t dtype,
                           const Machine& machine) {
  if (flat.backend != BackendKind::onnx || !request.fused || !request.programs_refused().empty()) return nullptr;
  if (request.device_type != CHIASM_CPU) return nullptr;
  std::string why_not;
  if (best_fit(method, BackendKind::native, request, dtype, machine, why_not) == nullptr) return nullptr;
  for (const Artifact& artifact : method.artifacts) {
    if (!artifact.function.empty() && misfit(artifact, request, dtype, machine).empty()) return &artifact;
  }
  return nullptr;
}

Choice choose(const MethodSpec& method, const LoadRequest& request, int32_t dtype, const Machine& machine, Registry& registry) {
  std::string reasons;
  chiasm_code code = CHIASM_NOT_FOUND;
  const auto add_reason = [&reasons](const std::string& reason) { reasons += (reasons.empty() ? " " : "; ") + reason; };
  for (int32_t i = 0; i < kBackendCount; ++i) {
    const auto kind = static_cast<BackendKind>(i);
    if (request.backend && *request.backend != kind) continue;
    const std::string name = kBackendNames[i];
    std::string why_not;
    const Artifact* best = best_fit(method, kind, request, dtype, machine, why_not);
    if (best == nullptr) {
      add_reason(name + ": " + why_not);
      continue;
    }
    const std::string refused = request.programs_refused();
    if (is_program(*best) && !refused.empty()) {
      add_reason(name + ": its artifacts are programs, and " + refused);
      if (code == CHIASM_NOT_FOUND) code = request.data_only ? CHIASM_UNTRUSTED : CHIASM_FAILED_PRECONDITION;
      continue;
    }
    const Backend& backend = registry.get(kind);
    if (backend.table == nullptr) {
      add_reason(name + ": " + backend.problem);
      code = CHIASM_UNAVAILABLE;
      continue;
    }
    if (request.device_type == CHIASM_CUDA && !backend.has_cuda) {
      add_reason(name + ": its engine (" + backend.engine_version + ") cannot use CUDA here");
      code = CHIASM_UNAVAILABLE;
      continue;
    }
    return {best, &backend};
  }
  fail(code, "no backend can run method '" + method.name + "' here:" + reasons);
}

}  // namespace chiasm::core
