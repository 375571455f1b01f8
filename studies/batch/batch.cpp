// Runs exported bundles on batches of images, compared with OpenCV, without Python.
//
//     study_batch results SETTINGS.json WORK
//         both contenders' results for the first photographs, as files next to the settings: WORK.chiasm.raw,
//         WORK.OpenCV.raw
//     study_batch race SETTINGS.json WORK THREADS
//         median milliseconds of both in turns: one line of JSON per batch size
//     study_batch memory SETTINGS.json WORK chiasm|OpenCV
//         the most megabytes that a batch and its results add to the process, per image
//
// `python -m studies.batch` writes SETTINGS.json: the folder of bundles, photographs as a file of bytes (N,
// 3, H, W), batch sizes, repeats.
#include <malloc.h>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include <chiasm/chiasm.hpp>
#include <chiasm/opencv.hpp>
#include <opencv2/core.hpp>

#include "../../bench/harness.hpp"
#include "opencv_ways.hpp"

using nlohmann::json;

namespace {

constexpr int kCompared = 3;
constexpr std::chrono::milliseconds kPause(20);  // until the other contender's threads sleep

json read_json(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  return json::parse(file);
}

// A work and its photographs.
struct Task {
  std::string work, bundle;
  cv::Size size;
  std::vector<std::vector<cv::Mat>> photographs;  // planes R, G, B of bytes
  json config;

  Task(const json& settings, const std::string& work)
      : work(work), size(settings.at("size").at(1), settings.at("size").at(0)) {
    if (!settings.at("works").contains(work)) throw std::runtime_error("there is no work " + work);
    bundle = settings.at("works").at(work).at("bundle");
    const std::string path = settings.at("photographs");
    std::ifstream file(path, std::ios::binary);
    for (cv::Mat plane(size, CV_8U);
         file.read(reinterpret_cast<char*>(plane.data), std::streamsize(plane.total()));
         plane = cv::Mat(size, CV_8U)) {
      if (photographs.empty() || photographs.back().size() == 3) photographs.emplace_back();
      photographs.back().push_back(plane);
    }
    if (photographs.empty() || photographs.back().size() != 3)
      throw std::runtime_error(path + " holds no whole photographs of this size");
    config = read_json(bundle + "/manifest.json").at("config");
  }

  bool frames() const { return work == "edges" || work == "preprocess"; }

  // Photograph i, cyclically, in the form that OpenCV takes: frames of bytes, BGR, or float32, RGB, in [0,
  // 1].
  cv::Mat image(int i) const {
    auto planes = photographs[size_t(i) % photographs.size()];
    if (frames()) std::swap(planes[0], planes[2]);
    cv::Mat bytes, floats;
    cv::merge(planes, bytes);
    if (frames()) return bytes;
    bytes.convertTo(floats, CV_32F, 1 / 255.0);
    return floats;
  }
};

// chiasm's native code on a batch: one call, or one call per frame.
class Chiasm {
 public:
  Chiasm(const Task& task, int batch)
      : method_(chiasm::Bundle::open(task.bundle)
                    .method("forward", chiasm::LoadOptions().with_backend("native"))) {
    const auto add = [&](const chiasm::Tensor& input) {
      const auto type = method_.output_type({input});
      made_.emplace_back(1, int(type.shape.count()), type.dtype == chiasm::DType::UInt8 ? CV_8U : CV_32F);
      inputs_.push_back(input);
      outputs_.emplace_back(static_cast<void*>(made_.back().data), type.dtype, type.shape);
    };
    if (task.frames()) {
      for (int i = 0; i < batch; ++i) frames_.push_back(task.image(i));
      for (const cv::Mat& frame : frames_) add(chiasm::view(frame));
    } else {
      for (int i = 0; i < batch; ++i)
        for (const cv::Mat& plane : task.photographs[size_t(i) % task.photographs.size()])
          std::transform(plane.begin<uchar>(), plane.end<uchar>(), std::back_inserter(pixels_),
                         [](uchar b) { return float(b) / 255; });
      add(chiasm::Tensor(pixels_.data(), {batch, 3, task.size.height, task.size.width}));
    }
  }

  void call() {
    for (size_t i = 0; i < inputs_.size(); ++i) method_.run_into({inputs_[i]}, {outputs_[i]});
  }

  // Plane after plane.
  std::vector<float> results() const {
    std::vector<float> all;
    for (const auto& t : outputs_) {
      if (t.dtype() == chiasm::DType::UInt8)
        all.insert(all.end(), t.data<const uint8_t>(), t.data<const uint8_t>() + t.count());
      else
        all.insert(all.end(), t.data<const float>(), t.data<const float>() + t.count());
    }
    return all;
  }

 private:
  chiasm::Method method_;
  std::vector<cv::Mat> frames_, made_;
  std::vector<float> pixels_;
  std::vector<chiasm::Tensor> inputs_, outputs_;
};

// OpenCV takes one image per call: threads share the images of a batch.
class OpenCv {
 public:
  OpenCv(const Task& task, int batch, int threads) : results_(size_t(batch)) {
    for (int i = 0; i < batch; ++i) images_.push_back(task.image(i));
    for (int k = 0; k < std::min(threads, batch); ++k)
      workers_.push_back(ways::named(task.work, task.config, task.size));
  }

  void call() {
    const size_t shares = workers_.size();
    const auto share = [&](const cv::Range& range) {
      for (auto k = size_t(range.start); k < size_t(range.end); ++k)
        for (size_t i = images_.size() * k / shares; i < images_.size() * (k + 1) / shares; ++i)
          workers_[k](images_[i], results_[i]);
    };
    if (shares == 1)
      share({0, 1});
    else
      cv::parallel_for_({0, int(shares)}, share, double(shares));
  }

  std::vector<float> results() const {
    std::vector<float> all;
    for (const cv::Mat& result : results_) {
      std::vector<cv::Mat> planes;
      cv::split(result, planes);
      for (auto& plane : planes) {
        plane.convertTo(plane, CV_32F);
        all.insert(all.end(), plane.begin<float>(), plane.end<float>());
      }
    }
    return all;
  }

 private:
  std::vector<cv::Mat> images_, results_;
  std::vector<ways::OnImage> workers_;
};

void write(const std::string& path, const std::vector<float>& values) {
  std::ofstream file(path, std::ios::binary);
  if (!file.write(reinterpret_cast<const char*>(values.data()),
                  std::streamsize(values.size() * sizeof(float))))
    throw std::runtime_error("cannot write " + path);
}

json write_results(const Task& task, const std::string& folder) {
  Chiasm ours(task, kCompared);
  OpenCv theirs(task, kCompared, 1);
  ours.call();
  theirs.call();
  write(folder + "/" + task.work + ".chiasm.raw", ours.results());
  write(folder + "/" + task.work + ".OpenCV.raw", theirs.results());
  return {{"opencv", CV_VERSION}};
}

// Like studies/batch/race.py: the contenders take turns, each with as many calls as fit into `seconds`, and
// each turn begins with a call that does not count.
json race(const std::vector<std::pair<std::string, std::function<void()>>>& contenders, const json& settings,
          bool pause) {
  const int turns = settings.at("turns"), repeats = settings.at("repeats");
  const double limit = settings.at("seconds").get<double>() * 1e6;
  std::vector<int> wanted;
  std::vector<std::vector<double>> times(contenders.size());
  for (const auto& [name, call] : contenders) {
    call();
    const auto start = bench::Clock::now();
    call();
    wanted.push_back(
        std::min(std::max(int(limit / std::max(bench::microseconds_since(start), 0.1)), 3), repeats));
  }
  for (int turn = 0; turn < turns; ++turn)
    for (size_t k = 0; k < contenders.size(); ++k) {
      const int count = wanted[k] * (turn + 1) / turns - wanted[k] * turn / turns;
      if (count == 0) continue;
      if (pause) std::this_thread::sleep_for(kPause);
      for (const auto start = bench::Clock::now(); pause && bench::Clock::now() - start < kPause / 2;)
        contenders[k].second();
      contenders[k].second();
      for (int i = 0; i < count; ++i) {
        const auto start = bench::Clock::now();
        contenders[k].second();
        times[k].push_back(bench::microseconds_since(start));
      }
    }
  json result;
  for (size_t k = 0; k < contenders.size(); ++k)
    result[contenders[k].first] = {{"ms", bench::median(times[k]) / 1000}, {"repeats", times[k].size()}};
  return result;
}

void run_race(const json& settings, const Task& task, int threads) {
  chiasm::set_num_threads(threads);
  cv::setNumThreads(threads);
  for (const int batch : settings.at("works").at(task.work).at("batches")) {
    Chiasm a(task, batch);
    OpenCv b(task, batch, threads);
    std::cout << json{{"batch", batch},
                      {"times",
                       race({{"chiasm native, C++", [&] { a.call(); }}, {"OpenCV, C++", [&] { b.call(); }}},
                            settings, threads > 1)}}
              << std::endl;
  }
}

// A field of /proc/self/status, in megabytes.
double memory(const std::string& field) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind(field + ":", 0) == 0) return std::stod(line.substr(field.size() + 1)) / 1024;
  throw std::runtime_error("no " + field + " in /proc/self/status");
}

// The peak of memory that a call and its results add. One image is run first, so that one-time loading does
// not count.
template <class Contender>
json grown(Contender&& one, Contender&& batch, int images) {
  one.call();
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << 5;  // resets the peak
  const double before = memory("VmRSS");
  batch.call();
  return {{"mb", (memory("VmHWM") - before) / images}};
}

json run_memory(const json& settings, const Task& task, const std::string& who) {
  chiasm::set_num_threads(1);
  cv::setNumThreads(1);
  const int batch = settings.at("memory_batch");
  if (who == "chiasm") return grown(Chiasm(task, 1), Chiasm(task, batch), batch);
  if (who == "OpenCV") return grown(OpenCv(task, 1, 1), OpenCv(task, batch, 1), batch);
  throw std::runtime_error("expected chiasm or OpenCV, got " + who);
}

}  // namespace

int main(int argc, char** argv) try {
  const std::vector<std::string> a(argv + 1, argv + argc);
  const bool results = a.size() == 3 && a[0] == "results", race = a.size() == 4 && a[0] == "race",
             memory = a.size() == 4 && a[0] == "memory";
  if (!results && !race && !memory) {
    std::cerr << "usage: study_batch results SETTINGS.json WORK | race SETTINGS.json WORK THREADS | memory "
                 "SETTINGS.json WORK chiasm|OpenCV\n";
    return 2;
  }
  const json settings = read_json(a[1]);
  const Task task(settings, a[2]);
  if (race)
    run_race(settings, task, std::stoi(a[3]));
  else
    std::cout << (results ? write_results(task, a[1].substr(0, a[1].rfind('/')))
                          : run_memory(settings, task, a[3]))
              << std::endl;
  return 0;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
