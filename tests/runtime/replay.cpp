// replay BUNDLE...: runs each bundle's native code for this CPU on the bundle's golden inputs.
//
// Prints a line for each result, OP METHOD DTYPE CASE OUTPUT SHA256, which shows whether another CPU has the
// same bits. The self-test shows whether it is correct, in lines TEST OP ARTIFACT ERROR and FAIL OP: WHAT.
// The exit status is 1 if one is wrong, or if a bundle has no native code for this CPU.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "base/dtype.h"
#include "chiasm/chiasm.hpp"
#include "core/bundle.h"
#include "core/file.h"
#include "core/safetensors.h"
#include "core/trust.h"

namespace {

namespace core = chiasm::core;

int failures = 0;

void report(const std::string& op, const std::string& what) {
  std::printf("FAIL %s: %s\n", op.c_str(), what.c_str());
  ++failures;
}

void self_test(const std::string& op, const chiasm::Bundle& bundle) {
  chiasm::LoadOptions options;
  options.backend = "native";
  int passed = 0;
  for (const chiasm::SelfTestRow& row : bundle.self_test(options)) {
    if (row.result == chiasm::SelfTestRow::Result::Failed) report(op, row.artifact + ": " + row.message);
    if (row.result != chiasm::SelfTestRow::Result::Passed) continue;
    ++passed;
    std::printf("TEST %s %s %.9g\n", op.c_str(), row.artifact.c_str(), row.max_error);
  }
  if (passed == 0) report(op, "no native code for this CPU");
}

size_t bytes_of(const chiasm::Tensor& tensor) {
  size_t bytes = chiasm::base::kDTypes[static_cast<int32_t>(tensor.dtype())].size;
  for (const int64_t size : tensor.shape()) bytes *= static_cast<size_t>(size);
  return bytes;
}

void print_results(const std::string& op, const std::string& folder, const chiasm::Bundle& bundle) {
  const core::Bundle inside(folder.c_str(), core::use_trust());
  const core::Manifest& manifest = inside.manifest();
  const core::Bytes bytes = inside.read(manifest.golden);
  const auto stored = core::read_safetensors(bytes.data(), bytes.size(), folder);
  for (const core::GoldenCase& one : manifest.golden_cases) {
    const core::MethodSpec& spec = manifest.methods[one.method];
    chiasm::LoadOptions options;
    options.backend = "native";
    if (spec.generic) options.dtype = one.dtype;
    const chiasm::Method method = bundle.method(spec.name, options);
    std::vector<core::Bytes> data;  // golden tensors need not be aligned
    std::vector<chiasm::Tensor> inputs;
    for (const core::TensorSpec& input : spec.inputs) {
      const core::StoredTensor& golden = stored.at(one.prefix + "/" + input.name);
      data.emplace_back(golden.data, golden.data + golden.size);
      inputs.emplace_back(static_cast<const void*>(data.back().data()),
                          static_cast<chiasm::DType>(golden.dtype),
                          chiasm::Shape(golden.shape.data(), golden.shape.size()));
    }
    const chiasm::Outputs outputs = method.run(inputs);
    for (size_t i = 0; i < outputs.size(); ++i) {
      const chiasm::Tensor output = outputs[i];
      std::printf("%s %s %s %s %s %s\n", op.c_str(), spec.name.c_str(),
                  spec.generic ? chiasm::base::kDTypes[one.dtype].name : "-", one.prefix.c_str(),
                  spec.outputs[i].name.c_str(), core::sha256(output.data(), bytes_of(output)).c_str());
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::filesystem::path folder(argv[i]);
    const std::string op = folder.stem().string();
    try {
      const chiasm::Bundle bundle = chiasm::Bundle::open(folder.string());
      self_test(op, bundle);
      print_results(op, folder.string(), bundle);
    } catch (const std::exception& error) {
      report(op, error.what());
    }
  }
  std::printf("replay: %d bundles, %d failed\n", argc - 1, failures);
  return argc < 2 || failures > 0;
}
