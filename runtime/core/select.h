/** Which artifact of a method is loaded here, and by which backend. */
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/manifest.h"
#include "core/registry.h"
#include "core/trust.h"

namespace chiasm::core {

/** The caller's request. */
struct LoadRequest {
  std::string backend; /**< "" for auto */
  int32_t device_type = CHIASM_CPU;
  int32_t device_index = 0;
  bool allow_native_code = true;
  bool data_only = false;           /**< true: the trust policy forbids programs */
  int32_t dtype = kGeneric;         /**< the value of T; kGeneric: float32, else the first available */
  int32_t num_threads = 0;          /**< 0: as many as the process may use */
  std::vector<std::string> options; /**< "key=value", for the backend named above */
  /** `fused` of the C struct; false is passed on as fused=0 to backends with that option */
  bool fused = true;
  bool warm_up = false;

  /** Why artifacts that are programs may not be loaded; "" if they may. */
  std::string programs_refused() const;
  /** The options for a backend. */
  std::vector<std::string> options_for(const Backend& backend) const;
};

/** Checks the options of the C interface, of any version of it; NULL means the defaults. Throws Error
 *  (INVALID_ARGUMENT). */
LoadRequest read_load_options(const chiasm_load_options* options);

/** The request, restricted by a trust policy. */
LoadRequest under(const Trust& trust, LoadRequest request);

/** The machine that an artifact must fit. */
struct Machine {
  Isa isa = Isa::none; /**< the highest that the CPU supports */
  int64_t sm = 0;      /**< compute capability of the CUDA device asked for, 0 if there is none */
  GlibcVersion glibc;  /**< 0.0 if the C library is not glibc */
};

/** This machine, for a method on that device. Throws Error (UNAVAILABLE) if there is no such device. */
Machine this_machine(int32_t device_type, int32_t device_index);

/** The value of T: the one asked for, or the default, among those of `dtypes` that the method has an artifact
 *  for. kGeneric if the method has no T. Throws Error (NOT_FOUND) if there is no such artifact. */
int32_t choose_dtype(const MethodSpec& method, const std::vector<int32_t>& dtypes,
                     const LoadRequest& request);

/** Why this machine cannot run the artifact with T = dtype, e.g. "needs a CPU with x86-64-v4"; "" if it
 *  can. */
std::string incompatibility(const Artifact& artifact, const LoadRequest& request, int32_t dtype,
                            const Machine& machine);

/** The best artifact for a backend on this machine: the one for the highest CPU level. If none fits, returns
 *  NULL, and `why_not` says why each does not. */
const Artifact* best_fit(const MethodSpec& method, const std::string& backend, const LoadRequest& request,
                         int32_t dtype, const Machine& machine, std::string& why_not);

/** A backend's rank of an artifact that fits; below 0: it does not take the artifact. */
using Rank = std::function<int32_t(const Backend&, const Artifact&)>;

/** An artifact with the backend that loads it. */
struct Candidate {
  const Artifact* artifact;
  const Backend* backend;
};

/** Calls `load` with one candidate after the other, the best first, until it returns. If it throws
 *  UNAVAILABLE or VERSION_MISMATCH, the next candidate is tried; its other errors go on to the caller, and so
 *  do those of `rank`, and IO_ERROR where backends cannot be looked for or opened now.
 *
 *  If all fail, throws Error with each backend's reason. Its code is UNAVAILABLE if a backend, its engine or
 *  its device is missing; else that of the first backend that has an artifact: FAILED_PRECONDITION (native
 *  code not allowed), UNTRUSTED (programs forbidden by the policy), OUT_OF_MEMORY (for its engine),
 *  INVALID_ARGUMENT (its options leave out each artifact), VERSION_MISMATCH (of `load`); else NOT_FOUND (no
 *  artifact fits). */
void choose(const MethodSpec& method, const LoadRequest& request, int32_t dtype, const Machine& machine,
            Registry& registry, const Rank& rank, const std::function<void(const Candidate&)>& load);

}  // namespace chiasm::core
