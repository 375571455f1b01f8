// C++ measurements; `python -m bench` calls this and writes the tables.
//
//     bench speed BUNDLE THREADS B H W
//         interleaved, in microseconds: native code, ONNX Runtime (fused, stock), OpenCV, a copy
//     bench speed ... PHOTOGRAPH VALUES SECONDS
//         the same on a file of bytes (B, 3, H, W), with other inputs and sizes as JSON, without ONNX Runtime
//     bench results BUNDLE B H W PHOTOGRAPH VALUES FILE
//         writes OpenCV's results to a file, for comparison
//     bench load BUNDLE BACKEND
//         milliseconds to the first result on 256 x 256, and memory on top of the bare program
//     bench latency BUNDLE NUM_THREADS CONCURRENCY H W
//         milliseconds that each of several calling threads waits: the median and the 99th percentile
//     bench overhead BUNDLE ARTIFACT.so
//         microseconds of chiasm's run_into, and of the artifact's own call, on 16 x 16
#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iostream>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>

#include <chiasm/chiasm.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "harness.hpp"
#include "opencv_peers/batch.hpp"
#include "runtime/artifact/abi.h"
#include "runtime/base/dtype.h"

using nlohmann::json;

namespace {

// The source of the inputs: images from a file of bytes (B, C, H, W), or noise if there is no file; the
// values of other inputs by name.
struct Given {
  std::string photograph;
  json values = {{"sigma", 1.1}};
};

size_t bytes_of(const std::vector<chiasm::Tensor>& tensors) {
  size_t sum = 0;
  for (const auto& t : tensors)
    sum += size_t(t.shape().count()) * chiasm::base::kDTypes[size_t(t.dtype())].size;
  return sum;
}

// The inputs of a method at one size.
struct Inputs {
  std::vector<std::vector<char>> memory;
  std::vector<chiasm::Tensor> views;

  Inputs(const chiasm::MethodInfo& method, int64_t batch, int64_t height, int64_t width,
         const Given& given = {}) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(0, 1);
    bool turned = false;  // the second image is the first, rotated by 180 degrees
    for (const auto& input : method.inputs) {
      std::vector<int64_t> sizes;
      for (const auto& dim : input.dims) {
        const std::string& d = dim.expression;
        sizes.push_back(given.values.contains(d) ? int64_t(given.values[d])
                        : d == "B"               ? batch
                        : d == "C"               ? 3
                        : d == "H"               ? height
                        : d == "W"               ? width
                        : d == "N"               ? 64
                        : d == "OH"              ? height * 3 / 4
                        : d == "OW"              ? width * 3 / 4
                                                 : std::stoll(d));
      }
      const chiasm::Shape shape(sizes);
      const auto count = size_t(shape.count());
      const auto dtype =
          std::find(input.dtypes.begin(), input.dtypes.end(), chiasm::DType::Float32) != input.dtypes.end()
              ? chiasm::DType::Float32
              : input.dtypes[0];
      memory.emplace_back(count * (dtype == chiasm::DType::Float32 ? 4 : 1));
      auto* floats = reinterpret_cast<float*>(memory.back().data());
      if (input.layout == "NCHW" && !given.photograph.empty()) {
        std::vector<char> bytes(count);
        if (!std::ifstream(given.photograph, std::ios::binary).read(bytes.data(), std::streamsize(count)))
          throw std::runtime_error("cannot read " + given.photograph);
        if (std::exchange(turned, true)) std::reverse(bytes.begin(), bytes.end());
        if (dtype == chiasm::DType::Float32)
          std::transform(bytes.begin(), bytes.end(), floats,
                         [&](char b) { return float(uint8_t(b)) * float(input.value_max / 255); });
        else
          memory.back() = bytes;
      } else if (input.name == "map_x" || input.name == "map_y") {  // waves of five pixels
        for (size_t i = 0; i < count; ++i) {
          const float x = float(int64_t(i) % sizes.back()),
                      y = float(int64_t(i) / sizes.back() % sizes[sizes.size() - 2]);
          floats[i] = input.name == "map_x" ? x + 5 * std::sin(y / 20) : y + 5 * std::sin(x / 30);
        }
      } else if (given.values.contains(input.name)) {
        const auto& value = given.values[input.name];
        if (value.is_array() && value.size() != count)
          throw std::runtime_error(input.name + ": wrong number of values");
        for (size_t i = 0; i < count; ++i) floats[i] = value.is_array() ? value[i] : value;
      } else if (dtype == chiasm::DType::Float32) {
        std::generate_n(floats, count, [&] { return uniform(random); });
      } else {
        for (auto& byte : memory.back()) byte = char(random());
      }
      views.emplace_back(static_cast<void*>(memory.back().data()), dtype, shape);
    }
  }
};

chiasm::Method load(const std::string& path, const std::string& backend, bool fused = true) {
  return chiasm::Bundle::open(path).method("forward",
                                           chiasm::LoadOptions().with_backend(backend).with_fused(fused));
}

// Buffers for the method's outputs, so that neither contender allocates.
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

std::string op_of(const std::string& bundle) {
  return bundle.substr(bundle.rfind('/') + 1, bundle.rfind('.') - bundle.rfind('/') - 1);
}

peers::Peer opencv(const std::string& bundle, const Inputs& inputs) {
  auto peer = peers::opencv(op_of(bundle), inputs.views);
  if (!peer) throw std::runtime_error("OpenCV has no such op");
  return *peer;
}

// The mean difference of chiasm's planes from OpenCV's matrices, if these are kept and have as many values.
std::optional<double> mean_difference(const chiasm::Tensor& made, const peers::Peer& peer) {
  if (!peer.results || made.shape().size() != 4 || made.dtype() != chiasm::DType::Float32) return {};
  const auto ours = peers::planes(made);
  double sum = 0;
  size_t plane = 0;
  for (const auto& image : peer.results()) {
    std::vector<cv::Mat> theirs;
    cv::split(image, theirs);
    for (const auto& t : theirs) {
      if (plane == ours.size() || t.size() != ours[plane].size() || t.type() != CV_32F) return {};
      sum += cv::norm(t, ours[plane++], cv::NORM_L1);
    }
  }
  return sum / double(made.shape().count());
}

// Without ONNX Runtime on photographs: Python measures that.
json speed(const std::string& bundle, int threads, int64_t b, int64_t h, int64_t w, const Given& given,
           double seconds) {
  chiasm::set_num_threads(threads);
  cv::setNumThreads(threads);
  std::vector<std::pair<std::string, chiasm::Method>> methods;
  methods.emplace_back("native", load(bundle, "native"));
  if (given.photograph.empty()) {
    methods.emplace_back("fused", load(bundle, "onnx"));
    methods.emplace_back("stock", load(bundle, "onnx", false));
  }
  const auto info = methods[0].second.info();
  const bool frames = info.inputs[0].layout == "HWC";  // one frame per call, so a batch is several calls
  const Inputs inputs(info, frames ? 1 : b, h, w, given);
  const Outputs outputs(methods[0].second, inputs.views);
  const int64_t calls = frames ? b : 1;
  std::vector<std::function<void()>> contenders;
  for (auto& [name, method] : methods)
    contenders.push_back([&, &method = method] {
      for (int64_t i = 0; i < calls; ++i) method.run_into(inputs.views, outputs.views);
    });
  const auto peer = opencv(bundle, inputs);
  contenders.push_back([&] {
    for (int64_t i = 0; i < calls; ++i) peer.call();
  });
  // A copy whose reads and writes together are as many bytes as the inputs and outputs.
  const std::vector<char> source(size_t(calls) * (bytes_of(inputs.views) + bytes_of(outputs.views)) / 2, 1);
  std::vector<char> target(source.size(), 2);
  contenders.push_back([&] { std::memcpy(target.data(), source.data(), source.size()); });
  const auto times = bench::interleaved(contenders, threads, seconds);
  json result{{"opencv", times[methods.size()]}, {"copy", times.back()}, {"opencv_version", CV_VERSION}};
  if (const auto difference = mean_difference(outputs.views[0], peer)) result["difference"] = *difference;
  for (size_t i = 0; i < methods.size(); ++i) result[methods[i].first] = times[i];
  return result;
}

// Writes OpenCV's results, matrix after matrix, to a file, and returns a description of its content.
json results(const std::string& bundle, int64_t b, int64_t h, int64_t w, const Given& given,
             const std::string& path) {
  const Inputs inputs(load(bundle, "native").info(), b, h, w, given);
  const auto peer = opencv(bundle, inputs);
  if (!peer.results) throw std::runtime_error("OpenCV's results are not kept");
  peer.call();
  const auto matrices = peer.results();
  std::ofstream file(path, std::ios::binary);
  for (const auto& m : matrices)
    file.write(reinterpret_cast<const char*>(m.data), std::streamsize(m.total() * m.elemSize()));
  const auto& m = matrices.at(0);
  return {{"dtype", m.depth() == CV_8U ? "uint8" : "float32"},
          {"shape", {matrices.size(), m.rows, m.cols, m.channels()}}};
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
  return {{"first_result_ms", (loaded + bench::microseconds_since(second)) / 1000},
          {"memory_mb", bench::resident_megabytes() - before - input_bytes / (1 << 20)}};
}

// The milliseconds that each of several threads, which call one method, waits for a result.
json latency(const std::string& bundle, int num_threads, int concurrency, int64_t h, int64_t w) {
  chiasm::LoadOptions options;
  options.backend = "native";
  options.num_threads = num_threads;
  options.warm_up = true;
  const auto method = chiasm::Bundle::open(bundle).method("forward", options);
  std::vector<std::vector<double>> taken(static_cast<size_t>(concurrency));
  std::vector<std::thread> threads;
  for (auto& times : taken)
    threads.emplace_back([&] {
      const Inputs inputs(method.info(), 1, h, w);
      const Outputs outputs(method, inputs.views);
      for (const auto began = bench::Clock::now(); bench::microseconds_since(began) < 10e6;) {
        const auto start = bench::Clock::now();
        method.run_into(inputs.views, outputs.views);
        times.push_back(bench::microseconds_since(start) / 1000);
      }
    });
  for (std::thread& thread : threads) thread.join();
  std::vector<double> all;
  for (const auto& times : taken) all.insert(all.end(), times.begin(), times.end());
  std::sort(all.begin(), all.end());
  return {{"median_ms", all[all.size() / 2]}, {"p99_ms", all[all.size() * 99 / 100]}, {"calls", all.size()}};
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
  const auto* api =
      reinterpret_cast<chiasm_native_entry_fn>(dlsym(library, CHIASM_NATIVE_ENTRY))(CHIASM_NATIVE_ABI);
  char error[256] = "";
  void* model = nullptr;
  if (api->create(0, 0, &model, error, sizeof error)) throw std::runtime_error(error);
  std::vector<chiasm_tensor> in, out;
  for (const auto& t : inputs.views) in.push_back(t.c_tensor());
  for (const auto& t : outputs.views) out.push_back(t.c_tensor());
  const chiasm_native_host host{nullptr, allocate, release, nullptr, 0, 0, nullptr, 1};
  const auto times =
      bench::interleaved({[&] { method.run_into(inputs.views, outputs.views); },
                          [&] {
                            if (api->run(model, in.data(), out.data(), &host, error, sizeof error))
                              throw std::runtime_error(error);
                          }},
                         1);
  return {{"chiasm_us", times[0]}, {"engine_us", times[1]}};
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> a(argv + 1, argv + argc);
  try {
    json result;
    const auto size = [&](size_t i) { return std::stoll(a[i]); };
    if (a.size() == 6 && a[0] == "speed")
      result = speed(a[1], std::stoi(a[2]), size(3), size(4), size(5), {}, 1.5);
    else if (a.size() == 9 && a[0] == "speed")
      result =
          speed(a[1], std::stoi(a[2]), size(3), size(4), size(5), {a[6], json::parse(a[7])}, std::stod(a[8]));
    else if (a.size() == 8 && a[0] == "results")
      result = results(a[1], size(2), size(3), size(4), {a[5], json::parse(a[6])}, a[7]);
    else if (a.size() == 3 && a[0] == "load")
      result = load_cost(a[1], a[2]);
    else if (a.size() == 3 && a[0] == "overhead")
      result = overhead(a[1], a[2]);
    else if (a.size() == 6 && a[0] == "latency")
      result = latency(a[1], std::stoi(a[2]), std::stoi(a[3]), size(4), size(5));
    else
      throw std::runtime_error("usage: see the head of bench.cpp");
    std::cout << result << "\n";
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
