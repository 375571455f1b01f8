/** Tests of real bundles with every way to run them. The bundles are in the folder CHIASM_TEST_BUNDLES. A
 *  missing bundle is a failure, and so is a backend that was built and cannot be used. */
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "chiasm/chiasm.hpp"
#include "core/registry.h"

namespace chiasm::testing {

inline std::string bundle_folder() {
  const char* const folder = std::getenv("CHIASM_TEST_BUNDLES");
  return folder == nullptr ? "" : folder;
}

/** Fails by an exception if the bundle is missing. */
inline Bundle open(const std::string& name) { return Bundle::open(bundle_folder() + "/" + name + ".chiasm"); }

/** The backends that this build has. */
inline std::vector<std::string> built_backends() { return core::split_path(CHIASM_TEST_BACKENDS); }

/** These backends, and "onnx_flat": ONNX Runtime with standard operators, whereas "onnx" runs native code as
 *  one node. */
inline std::vector<std::string> ways_to_run() {
  std::vector<std::string> ways = built_backends();
  if (std::find(ways.begin(), ways.end(), "onnx") != ways.end()) ways.push_back("onnx_flat");
  return ways;
}

template <class T = float>
std::vector<T> random_values(size_t count, T low = 0, T high = 1) {
  static std::mt19937 generator(7);
  std::uniform_real_distribution<T> distribution(low, high);
  std::vector<T> values(count);
  for (T& value : values) value = distribution(generator);
  return values;
}

class OnBackend : public ::testing::TestWithParam<std::string> {
 protected:
  std::string backend() const { return GetParam().substr(0, GetParam().find('_')); }
  LoadOptions options() const {
    return LoadOptions().with_backend(backend()).with_fused(backend() == GetParam());
  }
};

/** Loads a method in float64, or in float32 if this backend does not have it in float64. */
inline Method load_widest(const Bundle& bundle, const std::string& name, LoadOptions options) {
  try {
    return bundle.method(name, options.with_dtype(DType::Float64));
  } catch (const Error& error) {
    if (error.code() != CHIASM_NOT_FOUND) throw;
    return bundle.method(name, options.with_dtype(DType::Float32));
  }
}

inline DType dtype_of_method(const Method& method) { return method.info().inputs[0].dtypes[0]; }

/** Runs a method with floating-point inputs in its own dtype; inputs and results are doubles. */
inline std::vector<std::vector<double>> run_widened(
    const Method& method, const std::vector<std::pair<std::vector<double>, Shape>>& inputs) {
  const bool wide = dtype_of_method(method) == DType::Float64;
  std::vector<std::vector<float>> narrowed;
  std::vector<Tensor> tensors;
  for (const auto& [values, shape] : inputs) {
    narrowed.emplace_back(values.begin(), values.end());
    tensors.push_back(wide ? Tensor(values.data(), shape) : Tensor(narrowed.back().data(), shape));
  }
  const Outputs outputs = method.run(tensors);
  std::vector<std::vector<double>> results;
  for (size_t i = 0; i < outputs.size(); ++i) {
    const auto count = outputs[i].count();
    if (wide) {
      results.emplace_back(outputs[i].data<double>(), outputs[i].data<double>() + count);
    } else {
      results.emplace_back(outputs[i].data<float>(), outputs[i].data<float>() + count);
    }
  }
  return results;
}

}  // namespace chiasm::testing
