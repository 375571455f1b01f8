/** What runs an artifact's forward: TorchScript's program, or a package of AOTInductor's. */
#pragma once

#include <ATen/ops/from_blob.h>
#include <torch/csrc/inductor/aoti_package/model_package_loader.h>
#include <torch/csrc/jit/api/module.h>
#include <torch/csrc/jit/python/update_graph_executor_opt.h>
#include <torch/csrc/jit/serialization/import.h>

#include <dlfcn.h>

#include <istream>
#include <optional>
#include <streambuf>
#include <string>
#include <utility>
#include <vector>

#include "backends/plugin.h"
#include "base/dtype.h"
#include "base/error.h"

namespace chiasm::torch_engine {

using base::Error;
using plugin::MemoryFile;
using Tensors = std::vector<at::Tensor>;

using base::kDTypes;
static_assert(kDTypes[CHIASM_FLOAT32].torch == int(at::kFloat) &&
                  kDTypes[CHIASM_BFLOAT16].torch == int(at::kBFloat16) &&
                  kDTypes[CHIASM_UINT16].torch == int(at::kUInt16),
              "the table has libtorch's own numbers");

inline at::ScalarType scalar_type(int32_t dtype) {
  if (!base::is_dtype(dtype)) throw Error(CHIASM_INVALID_ARGUMENT, "unknown dtype " + std::to_string(dtype));
  return static_cast<at::ScalarType>(kDTypes[dtype].torch);
}

// A tensor over the caller's memory.
inline at::Tensor view(const chiasm_tensor& tensor, at::Device device) {
  const at::IntArrayRef shape(tensor.shape, static_cast<size_t>(tensor.ndim));
  return at::from_blob(tensor.data, shape,
                       at::TensorOptions().dtype(scalar_type(tensor.dtype)).device(device));
}

inline Tensors views(const chiasm_tensor* tensors, size_t count, at::Device device) {
  Tensors result;
  result.reserve(count);
  for (size_t i = 0; i < count; ++i) result.push_back(view(tensors[i], device));
  return result;
}

// Bytes in memory as a stream that can be read and rewound.
class ByteBuffer : public std::streambuf {
 public:
  ByteBuffer(const void* data, size_t size) {
    char* begin = static_cast<char*>(const_cast<void*>(data));
    setg(begin, begin, begin + size);
  }

 protected:
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    char* base = from == std::ios_base::beg ? eback() : from == std::ios_base::cur ? gptr() : egptr();
    if (offset < eback() - base || offset > egptr() - base) return pos_type(off_type(-1));
    setg(eback(), base + offset, egptr());
    return gptr() - eback();
  }
  pos_type seekpos(pos_type position, std::ios_base::openmode mode) override {
    return seekoff(off_type(position), std::ios_base::beg, mode);
  }
};

// Runs an artifact's forward.
class Program {
 public:
  virtual ~Program() = default;
  virtual Tensors forward(Tensors inputs) = 0;
};

class Script final : public Program {
 public:
  Script(const chiasm_backend_load& request, at::Device device) {
    ByteBuffer buffer(request.data, request.size);
    std::istream stream(&buffer);
    module_ = torch::jit::load(stream, device);
    module_.eval();
    method_.emplace(module_.get_method("forward"));
    input_count_ = method_->function().getSchema().arguments().size() - 1;  // without self
  }

  size_t input_count() const { return input_count_; }

  Tensors forward(Tensors inputs) override {
    // Op by op as written: torch's optimising executor would profile the first runs and compile in the
    // second, for each new shape, which makes those runs many times slower.
    const OptimizerOff off;
    torch::jit::Stack stack;
    stack.reserve(inputs.size() + 1);
    for (at::Tensor& input : inputs) stack.emplace_back(std::move(input));
    return unpack((*method_)(std::move(stack)));
  }

 private:
  class OptimizerOff {
   public:
    OptimizerOff() : before_(torch::jit::getGraphExecutorOptimize()) {
      torch::jit::setGraphExecutorOptimize(false);
    }
    ~OptimizerOff() { torch::jit::setGraphExecutorOptimize(before_); }

   private:
    bool before_;
  };

  static Tensors unpack(const c10::IValue& result) {
    if (result.isTensor()) return {result.toTensor()};
    if (result.isTensorList()) return result.toTensorVector();
    if (!result.isTuple())
      throw Error(CHIASM_CORRUPT, "the program returned a " + result.tagKind() + ", expected tensors");
    Tensors tensors;
    for (const c10::IValue& element : result.toTupleRef().elements()) {
      if (!element.isTensor())
        throw Error(CHIASM_CORRUPT,
                    "the program returned a " + element.tagKind() + " in a tuple, expected tensors");
      tensors.push_back(element.toTensor());
    }
    return tensors;
  }

  torch::jit::Module module_;
  std::optional<torch::jit::Method> method_;
  size_t input_count_ = 0;
};

class Package final : public Program {
 public:
  // The loader needs a path. It gets that of a sealed file in memory, which nobody can change.
  Package(const chiasm_backend_load& request, at::Device device) {
    // The code in the package depends on libtorch.so, which we do not link; once it is open, the dynamic
    // linker finds it by name.
    static void* const libtorch = dlopen("libtorch.so", RTLD_NOW | RTLD_LOCAL);
    if (libtorch == nullptr) throw Error(CHIASM_UNAVAILABLE, dlerror());
    MemoryFile file("chiasm-artifact");
    file.write(request.data, request.size);
    file.seal();
    constexpr bool single_threaded = false;
    constexpr size_t runners = 8;  // how many runs may be in flight before the next waits
    loader_.emplace(file.path(), "model", single_threaded, runners,
                    device.is_cuda() ? device.index() : c10::DeviceIndex(-1));
  }

  Tensors forward(Tensors inputs) override { return loader_->boxed_run(std::move(inputs)); }

 private:
  std::optional<torch::inductor::AOTIModelPackageLoader> loader_;
};

}  // namespace chiasm::torch_engine
