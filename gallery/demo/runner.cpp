// Runs one bundle on prepared cases with one backend, or OpenCV's version of the same work, and reports on
// stdout in JSON: largest error against eager Python, load time, memory, time per run.
//
//     demo_runner CASES.json native|torch|onnx|opencv
//
// Each process runs one backend, so that the memory is that backend's.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <chiasm/chiasm.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "harness.hpp"
#include "opencv_peers.hpp"

using bench::Clock;
using nlohmann::json;

namespace {

double milliseconds_since(Clock::time_point start) { return bench::microseconds_since(start) / 1000; }

chiasm::DType dtype_named(const std::string& name) {
  for (int32_t i = 0;; ++i) {
    const std::string each = chiasm::name(static_cast<chiasm::DType>(i));
    if (each == name) return static_cast<chiasm::DType>(i);
    if (each == "unknown") throw std::runtime_error("there is no dtype " + name);
  }
}

// Calls body(T{}) with the C++ type of a result's dtype.
template <class Body>
auto with_type(chiasm::DType dtype, const Body& body) {
  switch (dtype) {
    case chiasm::DType::Bool:
    case chiasm::DType::UInt8: return body(uint8_t{});
    case chiasm::DType::Int16: return body(int16_t{});
    case chiasm::DType::UInt16: return body(uint16_t{});
    case chiasm::DType::Int32: return body(int32_t{});
    case chiasm::DType::Int64: return body(int64_t{});
    case chiasm::DType::Float16: return body(_Float16{});
    case chiasm::DType::Float32: return body(float{});
    case chiasm::DType::Float64: return body(double{});
    default: throw std::runtime_error(std::string("cases have no ") + chiasm::name(dtype));
  }
}

// A tensor that was written as raw bytes next to the case file.
struct Loaded {
  std::vector<char> bytes;
  chiasm::DType dtype;
  chiasm::Shape shape;

  Loaded(const json& entry, const std::string& folder) {
    dtype = dtype_named(entry.at("dtype"));
    shape = chiasm::Shape(entry.at("shape").get<std::vector<int64_t>>());
    const std::string path = folder + "/" + entry.at("file").get<std::string>();
    std::ifstream file(path, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(file), {});
    const size_t expected =
        size_t(shape.count()) * with_type(dtype, [](auto value) { return sizeof(value); });
    if (bytes.size() != expected)
      throw std::runtime_error(path + ": expected " + std::to_string(expected) + " bytes, got " +
                               std::to_string(bytes.size()));
  }

  chiasm::Tensor view() { return {static_cast<void*>(bytes.data()), dtype, shape}; }
};

// The largest difference and how many values differ by more than atol + rtol * |expected|.
struct Difference {
  double error = 0;
  int64_t wrong = 0;
};

template <class T>
Difference difference(const T* a, const T* b, int64_t n, double atol, double rtol) {
  Difference d;
  for (int64_t i = 0; i < n; ++i) {
    const auto x = double(a[i]), y = double(b[i]);
    if (x == y || (std::isnan(x) && std::isnan(y))) continue;
    d.error = std::max(d.error, std::fabs(x - y));
    d.wrong += !(std::fabs(x - y) <= atol + rtol * std::fabs(y));
  }
  return d;
}

Difference compare(const chiasm::Tensor& result, Loaded& expected, const json& entry) {
  if (result.dtype() != expected.dtype ||
      !std::equal(result.shape().begin(), result.shape().end(), expected.shape.begin(), expected.shape.end()))
    throw std::runtime_error("an output has another shape or dtype than eager Python's");
  const int64_t n = result.shape().count();
  const double atol = entry.at("atol"), rtol = entry.at("rtol");
  const void *a = result.data(), *b = expected.bytes.data();
  return with_type(result.dtype(), [&](auto value) {
    return difference(static_cast<const decltype(value)*>(a), static_cast<const decltype(value)*>(b), n, atol,
                      rtol);
  });
}

// The median milliseconds of a call, which is repeated for some time.
template <class Call>
double median_milliseconds(Call call) {
  call();
  std::vector<double> times;
  const auto start = Clock::now();
  while (times.size() < 5 || (milliseconds_since(start) < 150 && times.size() < 200)) {
    const auto begin = Clock::now();
    call();
    times.push_back(milliseconds_since(begin));
  }
  return bench::median(std::move(times));
}

json run_chiasm(const json& cases, const std::string& folder, const std::string& backend) {
  const double before = bench::resident_megabytes();
  const auto start = Clock::now();
  auto bundle = chiasm::Bundle::open(cases.at("bundle").get<std::string>());
  chiasm::LoadOptions options;
  options.backend = backend;
  options.fused = false;  // onnx with standard operators: native code has its own column
  // Empty if the op has only one type
  if (const auto dtype = cases.at("dtype").get<std::string>(); !dtype.empty())
    options = options.with_dtype(dtype_named(dtype));
  auto method = bundle.method("forward", options);
  json report{{"load_ms", milliseconds_since(start)}, {"cases", json::array()}};
  bool first = true;
  for (const json& entry : cases.at("cases")) {
    std::vector<Loaded> inputs;
    for (const json& tensor : entry.at("inputs")) inputs.emplace_back(tensor, folder);
    std::vector<chiasm::Tensor> views;
    for (auto& input : inputs) views.push_back(input.view());
    auto outputs = method.run(views);
    if (first) report["memory_mb"] = bench::resident_megabytes() - before;
    Difference worst;
    for (size_t i = 0; i < outputs.size(); ++i) {
      const json& want = entry.at("outputs").at(i);
      Loaded expected(want, folder);
      const auto d = compare(outputs[i], expected, want);
      worst.error = std::max(worst.error, d.error);
      worst.wrong += d.wrong;
      std::ofstream(folder + "/" + backend + "." + want.at("file").get<std::string>(), std::ios::binary)
          .write(static_cast<const char*>(outputs[i].data()), std::streamsize(expected.bytes.size()));
    }
    json row{{"shape", entry.at("shape")}, {"error", worst.error}, {"wrong", worst.wrong}};
    row["ms"] = median_milliseconds([&] { outputs = method.run(views); });
    report["cases"].push_back(row);
    first = false;
  }
  return report;
}

json run_opencv(const json& cases, const std::string& folder) {
  json report{{"cases", json::array()}};
  for (const json& entry : cases.at("cases")) {
    std::vector<Loaded> inputs;
    for (const json& tensor : entry.at("inputs")) inputs.emplace_back(tensor, folder);
    std::vector<chiasm::Tensor> views;
    for (auto& input : inputs) views.push_back(input.view());
    const auto peer = peers::opencv(cases.at("name"), views);
    if (!peer) break;
    report["cases"].push_back({{"shape", entry.at("shape")}, {"ms", median_milliseconds(peer->call)}});
  }
  return report;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: demo_runner CASES.json native|torch|onnx|opencv\n";
    return 2;
  }
  try {
    const std::string path = argv[1], backend = argv[2];
    const json cases = json::parse(std::ifstream(path));
    const std::string folder = path.substr(0, path.rfind('/'));
    cv::setNumThreads(cv::getNumberOfCPUs());
    std::cout << (backend == "opencv" ? run_opencv(cases, folder) : run_chiasm(cases, folder, backend))
              << "\n";
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
