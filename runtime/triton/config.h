/** A model's config.pbtxt: chiasm's parameters in it, and its completion from the bundle. */
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "chiasm/chiasm.hpp"

namespace chiasm::triton {

/** The `parameters` of a configuration. */
struct Parameters {
  std::string method = "forward";
  /** One thread per run: instances and the requests of a batch run at once already. */
  LoadOptions load = LoadOptions().with_num_threads(1);
};

/** Throws Failure for an unknown parameter or value. */
Parameters read_parameters(const nlohmann::json& config);

/** How a method looks from Triton's side. */
struct Signature {
  MethodInfo method;
  /** How many samples a request may hold, if the first dimension of every input and output counts independent
   *  samples (Triton's configuration then leaves it out); else 0. */
  int64_t most_samples = 0;
};

/** `manifest` is the bundle's. */
Signature read_signature(const MethodInfo& method, const std::string& manifest);

/** The configuration, with missing inputs, outputs and max_batch_size filled in. Throws Failure if it
 *  contradicts the signature. */
nlohmann::json complete(nlohmann::json config, const Signature& signature);

}  // namespace chiasm::triton
