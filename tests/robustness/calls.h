/** Bundles loaded in every way that there is, and calls of them with inputs that fit. */
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "chiasm/chiasm.hpp"

namespace chiasm::testing {

/** Inputs of one call; they own their memory. */
struct Inputs {
  std::vector<std::vector<unsigned char>> bytes;
  std::vector<Tensor> tensors;
};

/** Inputs that the signature allows: the sizes of symbols within `largest` where the limits allow it, the
 *  values in the stated range or [0, 1]; both drawn with `seed`. Throws std::runtime_error where a size would
 *  need more than 64 MB. */
Inputs make_inputs(const MethodInfo& method, uint64_t seed, int64_t largest);

/** A loaded method. Gives the bytes of its outputs, one after the other. */
using Callable = std::function<std::string(const Inputs&)>;

/** What is built here of: native, torch, onnx (native code inside ONNX Runtime), onnx_flat (standard
 *  operators), and plugin: a session that the program itself makes of the fused file, with libchiasm_ort
 *  registered. */
std::vector<std::string> ways_to_call();

/** Throws Error, or Ort::Exception from a session. */
Callable load(const std::string& way, const std::string& bundle, const std::string& method = "forward");

/** The bytes of all outputs, one after the other. */
std::string bytes_of(const Outputs& outputs);

/** The folder of the test's bundles, and one of them. */
std::string bundle_path(const std::string& name);

/** What the process holds now. */
struct Holdings {
  int64_t maps = 0, files = 0, threads = 0, resident_kb = 0;
  static Holdings now();
  std::string text() const;
};

}  // namespace chiasm::testing
