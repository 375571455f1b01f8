/** A model's config.pbtxt: what it says for chiasm, and what the bundle says for it. */
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "chiasm/chiasm.hpp"

namespace chiasm::triton {

/** The `parameters` of a configuration. */
struct Parameters {
  std::string method = "forward";
  /** Of one thread: what runs at once are instances and the requests of a batch. */
  LoadOptions load = LoadOptions().with_num_threads(1);
};

/** Throws Failure for a parameter or a value that there is not. */
Parameters read_parameters(const nlohmann::json& config);

/** How a method looks from Triton's side. */
struct Signature {
  MethodInfo method;
  /** How many samples a request may hold where every input and output counts independent samples by its first
   *  dimension, which Triton's configuration then leaves out; else 0. */
  int64_t most_samples = 0;
};

/** `manifest` is the bundle's. */
Signature read_signature(const MethodInfo& method, const std::string& manifest);

/** The configuration with what it does not say: inputs, outputs and max_batch_size. Throws Failure where it says
 *  what the signature does not. */
nlohmann::json complete(nlohmann::json config, const Signature& signature);

}  // namespace chiasm::triton
