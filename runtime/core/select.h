/** Which artifact of a method is loaded here, and by which backend. */
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/manifest.h"
#include "core/registry.h"
#include "core/trust.h"

namespace chiasm::core {

/** What the caller asks for. */
struct LoadRequest {
  std::string backend; /**< "" for auto */
  int32_t device_type = CHIASM_CPU;
  int32_t device_index = 0;
  bool allow_native_code = true;
  bool data_only = false;           /**< the trust policy's word on the same */
  int32_t dtype = kGeneric;         /**< what T stands for; kGeneric for float32, else the first there is */
  int32_t num_threads = 0;          /**< 0: as many as the process may use */
  std::vector<std::string> options; /**< "key=value", for the backend that is named */
  /** false: the option fused=0 for the backend that has it; from before there were options */
  bool fused = true;
  bool warm_up = false;

  /** "" where artifacts that are programs may be loaded. */
  std::string programs_refused() const;
  /** The options for a backend. */
  std::vector<std::string> options_for(const Backend& backend) const;
};

/** Checks the options of the C interface, of any version of it; NULL stands for the defaults. Throws Error
 *  (INVALID_ARGUMENT). */
LoadRequest read_load_options(const chiasm_load_options* options);

/** The same within a trust policy. */
LoadRequest under(const Trust& trust, LoadRequest request);

/** What artifacts must fit to. */
struct Machine {
  Isa isa = Isa::none; /**< the highest that the CPU supports */
  int64_t sm = 0;      /**< compute capability of the CUDA device asked for, 0 where there is none */
  GlibcVersion glibc;  /**< 0.0 where the C library is another one */
};

/** This machine, for a method on that device. Throws Error (UNAVAILABLE) where there is no such device. */
Machine this_machine(int32_t device_type, int32_t device_index);

/** The value of T: the one asked for, or the default, among those of `dtypes` that the method has an artifact
 *  for. kGeneric where the method has no T. Throws Error (NOT_FOUND) where it is not offered. */
int32_t choose_dtype(const MethodSpec& method, const std::vector<int32_t>& dtypes,
                     const LoadRequest& request);

/** Why this machine cannot run the artifact with T = dtype, e.g. "needs a CPU with x86-64-v4"; "" where it
 *  can. */
std::string misfit(const Artifact& artifact, const LoadRequest& request, int32_t dtype,
                   const Machine& machine);

/** The artifact for a backend that suits this machine best: for its highest CPU level. NULL where none fits,
 *  and then `why_not` says why each does not. */
const Artifact* best_fit(const MethodSpec& method, const std::string& backend, const LoadRequest& request,
                         int32_t dtype, const Machine& machine, std::string& why_not);

/** How much a backend wants an artifact that fits; below 0: not at all. */
using Rank = std::function<int32_t(const Backend&, const Artifact&)>;

/** An artifact with the backend that loads it. */
struct Candidate {
  const Artifact* artifact;
  const Backend* backend;
};

/** Tries `load` with what can be loaded, the best first, until it returns. Where that throws UNAVAILABLE or
 *  VERSION_MISMATCH, the next is tried. Throws Error that says, for each backend, why not: NOT_FOUND (no
 *  artifact fits), FAILED_PRECONDITION (native code not allowed), UNTRUSTED, UNAVAILABLE (a backend is
 *  missing). */
void choose(const MethodSpec& method, const LoadRequest& request, int32_t dtype, const Machine& machine,
            Registry& registry, const Rank& rank, const std::function<void(const Candidate&)>& load);

}  // namespace chiasm::core
