/** Which artifact of a method is loaded here, and by which backend. */
#pragma once

#include <optional>
#include <string>

#include "core/registry.h"
#include "core/trust.h"

namespace chiasm::core {

/** What the caller asks for. */
struct LoadRequest {
  std::optional<BackendKind> backend; /**< none: auto */
  int32_t device_type = CHIASM_CPU;
  int32_t device_index = 0;
  bool allow_native_code = true;
  bool data_only = false; /**< the trust policy's word on the same */
  int32_t dtype = kGeneric; /**< what T stands for; kGeneric for float32, else the first there is */
  bool fused = true;
  bool warm_up = false;

  /** "" where artifacts that are programs may be loaded. */
  std::string programs_refused() const;
};

/** Whether loading it runs code that came with the bundle. */
inline bool is_program(const Artifact& artifact) { return artifact.backend != BackendKind::onnx || !artifact.function.empty(); }

/** Checks the options of the C interface; NULL stands for the defaults. Throws Error (INVALID_ARGUMENT). */
LoadRequest read_load_options(const chiasm_load_options* options);

/** The same within a trust policy. */
LoadRequest under(const Trust& trust, LoadRequest request);

/** What artifacts must fit to. */
struct Machine {
  Isa isa = Isa::none; /**< the highest that the CPU supports */
  int64_t sm = 0;      /**< compute capability of the CUDA device asked for, 0 where there is none */
};

/** This machine, for a method on that device. Throws Error (UNAVAILABLE) where there is no such device. */
Machine this_machine(int32_t device_type, int32_t device_index);

/** The value of T: the one asked for, or the default, among those of `dtypes` that the method has an artifact for. kGeneric
 *  where the method has no T. Throws Error (NOT_FOUND) where it is not offered. */
int32_t choose_dtype(const MethodSpec& method, const std::vector<int32_t>& dtypes, const LoadRequest& request);

/** Why this machine cannot run the artifact with T = dtype, e.g. "needs a CPU with x86-64-v4"; "" where it can. */
std::string misfit(const Artifact& artifact, const LoadRequest& request, int32_t dtype, const Machine& machine);

/** The best artifact for a backend on this machine: for its highest CPU level, in ONNX's flat form. NULL where none fits, and
 *  then `why_not` says why each does not. */
const Artifact* best_fit(const MethodSpec& method, BackendKind kind, const LoadRequest& request, int32_t dtype,
                         const Machine& machine, std::string& why_not);

/** The form of an onnx artifact whose native code can run inside ONNX Runtime here; NULL where there is none, or the caller
 *  does not want it. */
const Artifact* fused_form(const MethodSpec& method, const Artifact& flat, const LoadRequest& request, int32_t dtype,
                           const Machine& machine);

struct Choice {
  const Artifact* artifact;
  const Backend* backend;
};

/** The artifact to load. Throws Error that says, for each backend, why not: NOT_FOUND (no artifact fits),
 *  FAILED_PRECONDITION (native code not allowed), UNAVAILABLE (a backend is missing). */
Choice choose(const MethodSpec& method, const LoadRequest& request, int32_t dtype, const Machine& machine, Registry& registry);

}  // namespace chiasm::core
