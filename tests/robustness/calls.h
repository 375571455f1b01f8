/** Bundles loaded in every way, and calls of them with valid inputs. */
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

/** Inputs that the signature allows: sizes of symbols up to `largest` if their limits allow it, and values in
 *  the stated range or [0, 1]; both are drawn with `seed`. Throws std::runtime_error if a size would need
 *  more than 64 MB. */
Inputs make_inputs(const MethodInfo& method, uint64_t seed, int64_t largest);

/** A loaded method. Returns the bytes of its outputs, one after the other. */
using Callable = std::function<std::string(const Inputs&)>;

/** The ways of this build, out of: native, torch, onnx (native code inside ONNX Runtime), onnx_flat (standard
 *  operators), and plugin (a session that the program itself makes of the fused file, with libchiasm_ort
 *  registered). */
std::vector<std::string> ways_to_call();

/** Throws Error, or Ort::Exception from a session. */
Callable load(const std::string& way, const std::string& bundle, const std::string& method = "forward");

/** The bytes of all outputs, one after the other. */
std::string bytes_of(const Outputs& outputs);

/** The folder of the test's bundles, and one of them. */
std::string bundle_path(const std::string& name);

/** The resources that the process holds now. */
struct Holdings {
  int64_t maps = 0, files = 0, threads = 0, resident_kb = 0;
  static Holdings now();
  std::string text() const;
};

}  // namespace chiasm::testing
