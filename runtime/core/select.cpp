// Reads load options, tells which artifacts fit this machine and the request, and tries the backends that
// have some in the order of their priority.
#include "core/select.h"

#if defined(__GLIBC__)
#include <gnu/libc-version.h>
#endif

#include <algorithm>
#include <cstdio>
#include <optional>
#include <set>

#include "base/cuda.h"
#include "base/dtype.h"
#include "core/cpu.h"
#include "core/status.h"
#include "core/struct_size.h"
#include "core/threads.h"

namespace chiasm::core {

namespace {

std::vector<std::string> read_options(const char* const* options) {
  constexpr size_t kMost = 256;
  std::vector<std::string> read;
  for (const char* const* option = options; option != nullptr && *option != nullptr; ++option) {
    if (read.size() == kMost)
      fail(CHIASM_INVALID_ARGUMENT,
           "load options: more than " + std::to_string(kMost) + " options; the list ends with NULL");
    read.emplace_back(*option);
  }
  return read;
}

}  // namespace

LoadRequest read_load_options(const chiasm_load_options* options) {
  LoadRequest request;
  if (options == nullptr) return request;
  check_struct_size(options->struct_size, CHIASM_SIZE_THROUGH(chiasm_load_options, fused), "load options",
                    "start from CHIASM_LOAD_OPTIONS_INIT");
  if (options->backend != nullptr && std::string(options->backend) != "auto")
    request.backend = options->backend;
  if (!request.backend.empty() && !is_backend_name(request.backend)) {
    fail(CHIASM_INVALID_ARGUMENT,
         "load options: '" + request.backend +
             "' cannot be the name of a backend, which has lower-case letters, digits and underscores");
  }
  if (options->device_type != CHIASM_CPU && options->device_type != CHIASM_CUDA) {
    fail(CHIASM_INVALID_ARGUMENT,
         "load options: unknown device_type " + std::to_string(options->device_type));
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
  request.warm_up = options->warm_up != 0;
  request.fused = options->fused != 0;
  if (options->struct_size >= CHIASM_SIZE_THROUGH(chiasm_load_options, num_threads)) {
    request.num_threads = options->num_threads;
    check_num_threads(request.num_threads, "load options: num_threads");
  }
  if (options->struct_size >= CHIASM_SIZE_THROUGH(chiasm_load_options, options))
    request.options = read_options(options->options);
  if (!request.options.empty() && request.backend.empty()) {
    fail(CHIASM_INVALID_ARGUMENT,
         "load options: the option '" + request.options[0] + "' is for one backend: name it, not auto");
  }
  return request;
}

std::vector<std::string> LoadRequest::options_for(const Backend& backend) const {
  std::vector<std::string> all = backend.name() == this->backend ? options : std::vector<std::string>();
  for (const std::string& option : all) backend.check_option(option);
  if (!fused && backend.has_option("fused")) all.emplace_back("fused=0");
  std::set<std::string> keys;
  for (const std::string& option : all) {
    const std::string key = option.substr(0, option.find('='));
    if (!keys.insert(key).second)
      fail(CHIASM_INVALID_ARGUMENT, "load options: the option '" + key + "' is given twice");
  }
  return all;
}

LoadRequest under(const Trust& trust, LoadRequest request) {
  request.data_only = trust.policy == CHIASM_TRUST_DATA_ONLY;
  return request;
}

std::string LoadRequest::programs_refused() const {
  return data_only ? "the trust policy is 'data_only'" : !allow_native_code ? "allow_native_code is 0" : "";
}

Machine this_machine(int32_t device_type, int32_t device_index) {
  Machine machine;
  if (const std::vector<Isa> isas = supported_isas(); !isas.empty()) machine.isa = isas.back();
  if (device_type == CHIASM_CUDA) machine.sm = CudaDevice(device_index).capability();
#if defined(__GLIBC__)
  std::sscanf(::gnu_get_libc_version(), "%d.%d", &machine.glibc.major, &machine.glibc.minor);
#endif
  return machine;
}

int32_t choose_dtype(const MethodSpec& method, const std::vector<int32_t>& dtypes,
                     const LoadRequest& request) {
  if (!method.generic) return kGeneric;
  const int32_t asked = request.dtype;
  std::vector<int32_t> offered;
  for (const int32_t dtype : dtypes) {
    for (const Artifact& artifact : method.artifacts) {
      const bool wanted = request.backend.empty() || request.backend == artifact.backend;
      if (!wanted ||
          std::find(artifact.dtypes.begin(), artifact.dtypes.end(), dtype) == artifact.dtypes.end())
        continue;
      offered.push_back(dtype);
      break;
    }
  }
  if (offered.empty()) offered = dtypes;  // no artifact at all for that backend: `choose` reports it
  const auto has = [&offered](int32_t dtype) {
    return std::find(offered.begin(), offered.end(), dtype) != offered.end();
  };
  if (asked == kGeneric) return has(CHIASM_FLOAT32) ? CHIASM_FLOAT32 : offered.front();
  if (!has(asked)) {
    std::string all;
    for (const int32_t dtype : offered) all += (all.empty() ? "" : ", ") + std::string(dtype_name(dtype));
    fail(CHIASM_NOT_FOUND,
         "method '" + method.name + "' has no artifact for " + dtype_name(asked) + "; it has " + all);
  }
  return asked;
}

namespace {

std::string text_of(const GlibcVersion& version) {
  return std::to_string(version.major) + "." + std::to_string(version.minor);
}

}  // namespace

std::string incompatibility(const Artifact& artifact, const LoadRequest& request, int32_t dtype,
                            const Machine& machine) {
  if (dtype != kGeneric &&
      std::find(artifact.dtypes.begin(), artifact.dtypes.end(), dtype) == artifact.dtypes.end()) {
    return std::string("is not for ") + dtype_name(dtype);
  }
  const bool cuda = request.device_type == CHIASM_CUDA;
  if (cuda && artifact.device == DevicePlacement::cpu) return "is for the CPU";
  if (!cuda && artifact.device == DevicePlacement::cuda) return "is for CUDA";
  if (cuda && artifact.sm != 0) {
    // Code for 9.0 runs on 9.x, but neither on 8.x nor on 10.x.
    if (machine.sm / 10 != artifact.sm / 10 || machine.sm < artifact.sm) {
      return "is for a GPU of compute capability " + std::to_string(artifact.sm) + ", this one has " +
             std::to_string(machine.sm);
    }
  }
  const GlibcVersion &needed = artifact.glibc, &present = machine.glibc;
  if (needed.major > present.major || (needed.major == present.major && needed.minor > present.minor)) {
    return "needs glibc " + text_of(needed) +
           (present.major == 0 ? ", this machine has another C library"
                               : ", this machine has " + text_of(present));
  }
  if (!cuda && !has(machine.isa, artifact.isa))
    return std::string("needs a CPU with ") + isa_name(artifact.isa);
  return "";
}

namespace {

/** The artifacts for a backend that fit, those for the highest CPU level first; `why_not` says why the others
 *  do not. */
std::vector<const Artifact*> fitting(const MethodSpec& method, const std::string& backend,
                                     const LoadRequest& request, int32_t dtype, const Machine& machine,
                                     std::string& why_not) {
  std::vector<const Artifact*> found;
  for (const Artifact& artifact : method.artifacts) {
    if (artifact.backend != backend) continue;
    const std::string why = incompatibility(artifact, request, dtype, machine);
    if (why.empty()) {
      found.push_back(&artifact);
    } else {
      why_not += (why_not.empty() ? "" : ", ") + artifact.file + " " + why;
    }
  }
  const auto level = [](const Artifact* artifact) { return std::make_pair(artifact->isa, artifact->sm); };
  std::stable_sort(found.begin(), found.end(),
                   [&](const Artifact* a, const Artifact* b) { return level(a) > level(b); });
  return found;
}

/** Why an artifact in a format of the backend needs another engine too; "" if there is none. */
std::string needs_of(const MethodSpec& method, const Backend& backend) {
  for (const Artifact& artifact : method.artifacts) {
    if (artifact.needs.empty() || !backend.loads(artifact.format)) continue;
    return artifact.file + " needs " + artifact.needs[0] + (artifact.why.empty() ? "" : ": " + artifact.why);
  }
  return "";
}

/** Collects, for each backend, why it cannot run a method. */
class Reasons final {
 public:
  void add(const std::string& backend, const std::string& reason, chiasm_code code = CHIASM_NOT_FOUND) {
    text_ += (text_.empty() ? " " : "; ") + backend + ": " + reason;
    // Report the most useful code: something is missing on this machine, else something is forbidden, else
    // the bundle lacks an artifact.
    if (code != CHIASM_NOT_FOUND && (code_ == CHIASM_NOT_FOUND || code == CHIASM_UNAVAILABLE)) code_ = code;
    last_.reset();
    ++count_;
  }
  void add(const std::string& backend, const Error& error) {
    add(backend, error.what(), error.code());
    last_ = error;
  }
  [[noreturn]] void fail_for(const MethodSpec& method) const {
    if (count_ == 1 && last_) throw *last_;
    fail(code_, "no backend can run method '" + method.name +
                    "' here:" + (text_.empty() ? " none is installed" : text_));
  }

 private:
  std::string text_;
  chiasm_code code_ = CHIASM_NOT_FOUND;
  std::optional<Error> last_;
  int count_ = 0;
};

}  // namespace

const Artifact* best_fit(const MethodSpec& method, const std::string& backend, const LoadRequest& request,
                         int32_t dtype, const Machine& machine, std::string& why_not) {
  const std::vector<const Artifact*> found = fitting(method, backend, request, dtype, machine, why_not);
  if (found.empty() && why_not.empty()) why_not = "the bundle has no artifact for it";
  return found.empty() ? nullptr : found.front();
}

void choose(const MethodSpec& method, const LoadRequest& request, int32_t dtype, const Machine& machine,
            Registry& registry, const Rank& rank, const std::function<void(const Candidate&)>& load) {
  Reasons reasons;
  for (const auto& each : registry.all()) {
    const Backend& backend = *each;
    if (!request.backend.empty() && request.backend != backend.name()) continue;
    std::string why_not;
    std::vector<const Artifact*> found = fitting(method, backend.name(), request, dtype, machine, why_not);
    const auto leave_out = [&](const std::string& reason, const auto& which) {
      const auto end =
          std::stable_partition(found.begin(), found.end(), [&](const Artifact* a) { return !which(*a); });
      for (auto artifact = end; artifact != found.end(); ++artifact)
        why_not += (why_not.empty() ? "" : ", ") + (*artifact)->file + " " + reason;
      found.erase(end, found.end());
    };
    if (!found.empty() && backend.table() == nullptr) {
      reasons.add(backend.name(), backend.engine().problem, CHIASM_UNAVAILABLE);
      continue;
    }
    leave_out("is in a format that it does not load",
              [&](const Artifact& a) { return !backend.loads(a.format); });
    const bool had_some = !found.empty();
    const std::string refused = request.programs_refused();
    if (!refused.empty())
      leave_out("is a program, and " + refused,
                [&](const Artifact& a) { return backend.is_program(a.format); });
    if (found.empty()) {
      if (had_some) {
        reasons.add(backend.name(), "its artifacts are programs, and " + refused,
                    request.data_only ? CHIASM_UNTRUSTED : CHIASM_FAILED_PRECONDITION);
      } else {
        if (why_not.empty()) why_not = needs_of(method, backend);
        reasons.add(backend.name(), why_not.empty() ? "the bundle has no artifact for it" : why_not);
      }
      continue;
    }
    if (!backend.has_device(request.device_type)) {
      reasons.add(backend.name(), "it does not run on this kind of device", CHIASM_UNAVAILABLE);
      continue;
    }
    std::vector<std::pair<int32_t, const Artifact*>> ranked;
    for (const Artifact* artifact : found) ranked.emplace_back(rank(backend, *artifact), artifact);
    std::stable_sort(ranked.begin(), ranked.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    const Backend::Engine& engine = backend.engine();
    if (!engine.problem.empty()) {
      reasons.add(backend.name(), engine.problem, engine.code);
      continue;
    }
    if (request.device_type == CHIASM_CUDA && !engine.has_cuda) {
      reasons.add(backend.name(), "its engine (" + engine.version + ") cannot use CUDA here",
                  CHIASM_UNAVAILABLE);
      continue;
    }
    std::optional<Error> last;
    for (const auto& [order, artifact] : ranked) {
      if (order < 0) continue;
      try {
        return load({artifact, &backend});
      } catch (const Error& error) {
        if (error.code() != CHIASM_UNAVAILABLE && error.code() != CHIASM_VERSION_MISMATCH) throw;
        last = error;
      }
    }
    if (last) {
      reasons.add(backend.name(), *last);
    } else {
      reasons.add(backend.name(), "its options leave out each of its artifacts", CHIASM_INVALID_ARGUMENT);
    }
  }
  // backends that were requested, or that the method has artifacts for, and that are not installed
  std::vector<std::string> missing;
  if (!request.backend.empty()) missing.push_back(request.backend);
  for (const Artifact& artifact : method.artifacts) {
    if (request.backend.empty() &&
        std::find(missing.begin(), missing.end(), artifact.backend) == missing.end())
      missing.push_back(artifact.backend);
  }
  for (const std::string& name : missing) {
    if (registry.find(name) == nullptr) reasons.add(name, registry.not_found(name), CHIASM_UNAVAILABLE);
  }
  reasons.fail_for(method);
}

}  // namespace chiasm::core
