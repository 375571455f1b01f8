// C++ measurements; `python -m bench` calls this and writes the tables.
//
//     bench speed BUNDLE THREADS B H W             microseconds of native code, ONNX Runtime (fused, stock) and OpenCV, interleaved
//     bench load BUNDLE BACKEND                    milliseconds to the first result on 256 x 256, and memory over the bare program
//     bench overhead BUNDLE ARTIFACT.so            microseconds of chiasm's run_into and of the artifact's own call on 16 x 16
#include <dlfcn.h>

#include <cstring>
#include <iostream>
#include <random>
#include <string>

#include <chiasm/chiasm.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "harness.hpp"
#include "opencv_peers.hpp"
#include "runtime/shim/abi.h"

using nlohmann::json;

namespace {

// The inputs of a method at one size: noise for images and frames, plausible values for the rest.
struct Inputs {
  std::vector<std::vector<char>> memory;
  std::vector<chiasm::Tensor> views;

  Inputs(const chiasm::MethodInfo& method, int64_t batch, int64_t height, int64_t width) {
    std::mt19937 random(1);
    for (const auto& input : method.inputs) {
      std::vector<int64_t> sizes;
      for (const auto& dim : input.dims) {
        const std::string& d = dim.expression;
        sizes.push_back(d == "B" ? batch : d == "C" ? 3 : d == "H" ? height : d == "W" ? width : d == "N" ? 64 : d == "OH" ? height * 3 / 4 : d == "OW" ? width * 3 / 4 : std::stoll(d));
      }
      const chiasm::Shape shape(sizes);
      const auto dtype = std::find(input.dtypes.begin(), input.dtypes.end(), chiasm::DType::Float32) != input.dtypes.end() ? chiasm::DType::Float32 : input.dtypes[0];
      memory.emplace_back(size_t(shape.count()) * (dtype == chiasm::DType::Float32 ? 4 : 1));
      if (dtype == chiasm::DType::Float32) {
        auto* data = reinterpret_cast<float*>(memory.back().data());
        const bool sigma = input.name == "sigma";
        std::uniform_real_distribution<float> uniform(0, 1);
        for (int64_t i = 0; i < shape.count(); ++i) data[i] = sigma ? 1.1f : uniform(random);
      } else {
        for (auto& byte : memory.back()) byte = char(random());
      }
      views.emplace_back(static_cast<void*>(memory.back().data()), dtype, shape);
    }
  }
};

chiasm::Method load(const std::string& path, const std::string& backend, bool fused = true) {
  return chiasm::Bundle::open(path).method("forward", chiasm::LoadOptions().with_backend(backend).with_fused(fused));
}

// Room for the method's outputs, so that neither contender allocates.
struct Outputs {
  std::vector<std::vector<char>> memory;
  std::vector<chiasm::Tensor> views;

  Outputs(const chiasm::Method& method, const std::vector<chiasm::Tensor>& inputs) {
    for (size_t i = 0; i < method.info().outputs.size(); ++i) {
      const auto type = method.output_type(inputs, i);
      memory.emplace_back(size_t(type.shape.count()) * 8);
      views.emplace_back(static_cast<void*>(memory.back().data()), type.dtype, type.shape);
    }
  }
};

json speed(const std::string& bundle, int threads, int64_t b, int64_t h, int64_t w) {
  chiasm::set_num_threads(threads);
  cv::setNumThreads(threads);
  std::vector<chiasm::Method> methods;
  methods.push_back(load(bundle, "native"));
  methods.push_back(load(bundle, "onnx"));
  methods.push_back(load(bundle, "onnx", false));
  const auto info = methods[0].info();
  const bool frames = info.inputs[0].layout == "HWC";  // one frame a call: a batch is that many calls
  const Inputs inputs(info, frames ? 1 : b, h, w);
  const Outputs outputs(methods[0], inputs.views);
  const int64_t calls = frames ? b : 1;
  std::vector<std::function<void()>> contenders;
  for (auto& method : methods)
    contenders.push_back([&] {
      for (int64_t i = 0; i < calls; ++i) method.run_into(inputs.views, outputs.views);
    });
  const auto peer = peers::opencv(bundle.substr(bundle.rfind('/') + 1, bundle.rfind('.') - bundle.rfind('/') - 1), inputs.views);
  if (!peer) throw std::runtime_error("OpenCV has no such op");
  contenders.push_back([&] {
    for (int64_t i = 0; i < calls; ++i) (*peer)();
  });
  const auto times = bench::interleaved(contenders, 1.5);
  return {{"native", times[0]}, {"fused", times[1]}, {"stock", times[2]}, {"opencv", times[3]}, {"opencv_version", CV_VERSION}};
}

json load_cost(const std::string& bundle, const std::string& backend) {
  const double before = bench::resident_megabytes();
  const auto start = bench::Clock::now();
  auto method = load(bundle, backend);
  const double loaded = bench::microseconds_since(start);
  const Inputs inputs(method.info(), 1, 256, 256);
  const auto second = bench::Clock::now();
  auto outputs = method.run(inputs.views);
  const double input_bytes = double(inputs.memory[0].size());
  return {{"first_result_ms", (loaded + bench::microseconds_since(second)) / 1000}, {"memory_mb", bench::resident_megabytes() - before - input_bytes / (1 << 20)}};
}

void* allocate(void*, size_t bytes) { return std::aligned_alloc(64, (bytes + 63) / 64 * 64 + 64); }
void release(void*, void* data, size_t) { std::free(data); }

json overhead(const std::string& bundle, const std::string& artifact) {
  chiasm::set_num_threads(1);
  auto method = load(bundle, "native");
  const Inputs inputs(method.info(), 1, 16, 16);
  const Outputs outputs(method, inputs.views);
  void* library = dlopen(artifact.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) throw std::runtime_error(dlerror());
  const auto* api = reinterpret_cast<chiasm_native_entry_fn>(dlsym(library, CHIASM_NATIVE_ENTRY))(CHIASM_NATIVE_ABI);
  char error[256] = "";
  void* model = nullptr;
  if (api->create(0, 0, &model, error, sizeof error)) throw std::runtime_error(error);
  const auto native = [](const chiasm::Tensor& t) {
    return chiasm_native_tensor{const_cast<void*>(static_cast<const void*>(t.data())), int32_t(t.dtype()), int32_t(t.shape().size()), t.shape().data()};
  };
  std::vector<chiasm_native_tensor> in, out;
  for (const auto& t : inputs.views) in.push_back(native(t));
  for (const auto& t : outputs.views) out.push_back(native(t));
  const chiasm_native_host host{nullptr, allocate, release, nullptr, 0, 0, nullptr, 1};
  const auto times = bench::interleaved({[&] { method.run_into(inputs.views, outputs.views); },
                                         [&] { if (api->run(model, in.data(), out.data(), &host, error, sizeof error)) throw std::runtime_error(error); }});
  return {{"chiasm_us", times[0]}, {"engine_us", times[1]}};
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> a(argv + 1, argv + argc);
  try {
    json result;
    if (a.size() == 6 && a[0] == "speed") result = speed(a[1], std::stoi(a[2]), std::stoll(a[3]), std::stoll(a[4]), std::stoll(a[5]));
    else if (a.size() == 3 && a[0] == "load") result = load_cost(a[1], a[2]);
    else if (a.size() == 3 && a[0] == "overhead") result = overhead(a[1], a[2]);
    else throw std::runtime_error("usage: bench speed BUNDLE THREADS B H W | load BUNDLE BACKEND | overhead BUNDLE ARTIFACT.so");
    std::cout << result << "\n";
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
