#include "calls.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <numeric>
#include <random>
#include <sstream>
#include <stdexcept>

#include "core/registry.h"
#ifdef CHIASM_TEST_PLUGIN
#include <onnxruntime_cxx_api.h>

#include "backends/onnx/dtype.h"
#endif

namespace chiasm::testing {
namespace {

size_t size_of(DType dtype) {
  constexpr size_t kSizes[] = {1, 1, 1, 2, 4, 8, 2, 2, 4, 8};
  return kSizes[static_cast<int32_t>(dtype)];
}

template <class T>
void fill(std::vector<unsigned char>& bytes, std::mt19937_64& random, double low, double high) {
  std::uniform_real_distribution<double> values(low, high);
  for (size_t i = 0; i + sizeof(T) <= bytes.size(); i += sizeof(T)) {
    const T value = static_cast<T>(values(random));
    std::memcpy(bytes.data() + i, &value, sizeof value);
  }
}

void fill(std::vector<unsigned char>& bytes, std::mt19937_64& random, const TensorInfo& tensor) {
  const bool stated = tensor.value_min < tensor.value_max;
  const double low = stated ? tensor.value_min : 0, high = stated ? tensor.value_max : 1;
  const auto clamped = [&](double least, double most) {
    return std::pair(std::clamp(low, least, most), std::clamp(stated ? high : most, least, most));
  };
  switch (tensor.dtypes.at(0)) {
    case DType::Bool: return fill<bool>(bytes, random, 0, 2);
    case DType::UInt8: return fill<uint8_t>(bytes, random, clamped(0, 255).first, clamped(0, 255).second);
    case DType::Int8: return fill<int8_t>(bytes, random, clamped(-128, 127).first, clamped(-128, 127).second);
    case DType::UInt16: return fill<uint16_t>(bytes, random, clamped(0, 100).first, clamped(0, 100).second);
    case DType::Int16: return fill<int16_t>(bytes, random, clamped(0, 100).first, clamped(0, 100).second);
    case DType::Int32: return fill<int32_t>(bytes, random, clamped(0, 100).first, clamped(0, 100).second);
    case DType::Int64: return fill<int64_t>(bytes, random, clamped(0, 100).first, clamped(0, 100).second);
    case DType::Float32: return fill<float>(bytes, random, low, high);
    case DType::Float64: return fill<double>(bytes, random, low, high);
    case DType::Float16:
    case DType::BFloat16: return;  // zeros
  }
}

#ifdef CHIASM_TEST_PLUGIN

/** A session of the fused file, as in a service that uses ONNX Runtime. */
class Session {
 public:
  Session(const std::string& bundle, const std::string& method) {
    static Ort::Env& env = *new Ort::Env(ORT_LOGGING_LEVEL_ERROR, "robustness");
    Ort::SessionOptions options;
    options.SetIntraOpNumThreads(2);
    options.AddConfigEntry("chiasm.bundles", bundle.c_str());
    options.RegisterCustomOpsLibrary(CHIASM_TEST_PLUGIN);
    session_ = Ort::Session(env, fused_file(bundle, method).c_str(), options);
    Ort::AllocatorWithDefaultOptions allocator;
    for (size_t i = 0; i < session_.GetInputCount(); ++i)
      inputs_.emplace_back(session_.GetInputNameAllocated(i, allocator).get());
    for (size_t i = 0; i < session_.GetOutputCount(); ++i)
      outputs_.emplace_back(session_.GetOutputNameAllocated(i, allocator).get());
  }

  std::string run(const Inputs& inputs) {
    const auto memory = Ort::MemoryInfo::CreateCpu(OrtDeviceAllocator, OrtMemTypeDefault);
    std::vector<Ort::Value> values;
    for (const Tensor& tensor : inputs.tensors) {
      values.push_back(Ort::Value::CreateTensor(memory, tensor.data(),
                                                static_cast<size_t>(tensor.count()) * size_of(tensor.dtype()),
                                                tensor.shape().data(), tensor.shape().size(),
                                                onnx::element_type(static_cast<int32_t>(tensor.dtype()))));
    }
    std::vector<const char*> in, out;
    for (const std::string& name : inputs_) in.push_back(name.c_str());
    for (const std::string& name : outputs_) out.push_back(name.c_str());
    std::string bytes;
    for (Ort::Value& value : session_.Run(Ort::RunOptions(nullptr), in.data(), values.data(), values.size(),
                                          out.data(), out.size())) {
      const auto info = value.GetTensorTypeAndShapeInfo();
      const auto dtype = static_cast<DType>(onnx::dtype_of(info.GetElementType()));
      bytes.append(static_cast<const char*>(value.GetTensorRawData()),
                   info.GetElementCount() * size_of(dtype));
    }
    return bytes;
  }

 private:
  static std::string fused_file(const std::string& bundle, const std::string& method) {
    const std::string generic = bundle + "/" + method + ".float32.fused.onnx";
    return std::filesystem::exists(generic) ? generic : bundle + "/" + method + ".fused.onnx";
  }

  Ort::Session session_{nullptr};
  std::vector<std::string> inputs_, outputs_;
};

#endif

int64_t count_entries(const char* folder) {
  return std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator());
}

}  // namespace

std::string bytes_of(const Outputs& outputs) {
  std::string bytes;
  for (size_t i = 0; i < outputs.size(); ++i) {
    const Tensor tensor = outputs[i];
    bytes.append(static_cast<const char*>(tensor.data()),
                 static_cast<size_t>(tensor.count()) * size_of(tensor.dtype()));
  }
  return bytes;
}

Inputs make_inputs(const MethodInfo& method, uint64_t seed, int64_t largest) {
  std::mt19937_64 random(seed);
  std::map<std::string, int64_t> symbols;
  Inputs inputs;
  for (const TensorInfo& tensor : method.inputs) {
    std::vector<int64_t> shape;
    int64_t count = 1;
    for (const DimInfo& dim : tensor.dims) {
      const bool constant = std::all_of(dim.expression.begin(), dim.expression.end(),
                                        [](unsigned char c) { return std::isdigit(c) != 0; });
      const auto [entry, fresh] =
          symbols.emplace(dim.expression, constant ? std::strtoll(dim.expression.c_str(), nullptr, 10) : 0);
      const bool few = dim.expression == "B" || dim.expression == "C";  // images and channels
      const int64_t most = std::max(dim.min, std::min<int64_t>(dim.max, few ? 3 : largest));
      if (fresh && !constant) entry->second = std::uniform_int_distribution<int64_t>(dim.min, most)(random);
      shape.push_back(entry->second);
      if (entry->second > 0 && count > (int64_t{64} << 20) / entry->second)
        throw std::runtime_error("an input would be larger than 64 MB");
      count *= entry->second;
    }
    const DType dtype = tensor.dtypes.at(0);
    inputs.bytes.emplace_back(static_cast<size_t>(count) * size_of(dtype));
    fill(inputs.bytes.back(), random, tensor);
    inputs.tensors.emplace_back(static_cast<void*>(inputs.bytes.back().data()), dtype, Shape(shape));
  }
  return inputs;
}

std::vector<std::string> ways_to_call() {
  std::vector<std::string> ways = core::split_path(CHIASM_TEST_BACKENDS);
  if (std::find(ways.begin(), ways.end(), "onnx") != ways.end()) ways.push_back("onnx_flat");
#ifdef CHIASM_TEST_PLUGIN
  ways.push_back("plugin");
#endif
  return ways;
}

Callable load(const std::string& way, const std::string& bundle, const std::string& method) {
#ifdef CHIASM_TEST_PLUGIN
  if (way == "plugin")
    return [session = std::make_shared<Session>(bundle, method)](const Inputs& inputs) {
      return session->run(inputs);
    };
#endif
  const std::string backend = way.substr(0, way.find('_'));
  auto loaded = std::make_shared<Method>(
      Bundle::open(bundle).method(method, LoadOptions().with_backend(backend).with_fused(way == backend)));
  return [loaded](const Inputs& inputs) { return bytes_of(loaded->run(inputs.tensors)); };
}

std::string bundle_path(const std::string& name) {
  const char* const folder = std::getenv("CHIASM_TEST_BUNDLES");
  return std::string(folder == nullptr ? "build/bundles" : folder) + "/" + name + ".chiasm";
}

Holdings Holdings::now() {
  Holdings found;
  std::string line;
  std::ifstream maps("/proc/self/maps");
  while (std::getline(maps, line)) ++found.maps;
  found.files = count_entries("/proc/self/fd");
  found.threads = count_entries("/proc/self/task");
  int64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages >> pages;
  found.resident_kb = pages * ::sysconf(_SC_PAGESIZE) / 1024;
  return found;
}

std::string Holdings::text() const {
  std::ostringstream text;
  text << maps << " mappings, " << files << " files, " << threads << " threads, " << resident_kb / 1024
       << " MB";
  return text.str();
}

}  // namespace chiasm::testing
