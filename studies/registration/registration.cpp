// Registers two photographs, read from files, by gradient descent with exported bundles only: no Python, no
// torch.
//
//     study_registration BUNDLES native|onnx THREADS ITERATIONS LR SOURCE DESTINATION WARPED
//
// BUNDLES is the folder with registration.pyramid, registration.step and registration.warp, which `python -m
// studies.registration` makes. Prints JSON: for each level the homography from DESTINATION to SOURCE in
// normalised coordinates, and the loss; the last homography in pixels; milliseconds of CPU time from images
// to homography; whether a library of torch is in this process. Writes SOURCE, warped to DESTINATION, to the
// file WARPED.
#include <array>
#include <ctime>
#include <iostream>
#include <stdexcept>
#include <string>

#include <chiasm/chiasm.hpp>
#include <chiasm/opencv.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "../loaded.hpp"

using nlohmann::json;

namespace {

using Matrix = std::array<float, 9>;

constexpr Matrix kIdentity{1, 0, 0, 0, 1, 0, 0, 0, 1};

// The tensors that a step takes and returns.
struct State {
  Matrix homography = kIdentity, mean{}, square{};
};

chiasm::Tensor tensor(Matrix& m) { return {m.data(), {1, 3, 3}}; }
chiasm::Tensor scalar(float& value) { return {&value, chiasm::Shape()}; }

json scaled(const Matrix& m) {
  json entries = json::array();
  for (const float entry : m) entries.push_back(entry / m[8]);
  return entries;
}

class Registration {
 public:
  Registration(std::string folder, const std::string& backend)
      : folder_(std::move(folder)), backend_(backend) {}

  // From coarse to fine, with `iterations` steps at each level, each with a new state of Adam. Keeps the last
  // homography.
  json descend(const cv::Mat& source, const cv::Mat& destination, int iterations, float lr) {
    const chiasm::Outputs sources = pyramid_.run({chiasm::view(source)}),
                          targets = pyramid_.run({chiasm::view(destination)});
    homography_ = kIdentity;
    json levels = json::array();
    for (size_t level = sources.size(); level-- > 0;) {
      State state{homography_}, next;
      float loss = 0;
      for (int i = 1; i <= iterations; ++i) {
        auto step = float(i);
        step_.run_into(
            {sources[level], targets[level], tensor(state.homography), tensor(state.mean),
             tensor(state.square), scalar(step), scalar(lr)},
            {tensor(next.homography), tensor(next.mean), tensor(next.square), chiasm::Tensor(&loss, {1})});
        state = next;
      }
      homography_ = state.homography;
      levels.push_back({{"homography", scaled(homography_)}, {"loss", loss}});
    }
    return levels;
  }

  // Warps SOURCE to DESTINATION, and returns the homography in pixels.
  json warp(const cv::Mat& source, const std::string& file) {
    const chiasm::Outputs outputs = warp_.run({chiasm::view(source), tensor(homography_)});
    if (!cv::imwrite(file, chiasm::to_mat(outputs[0]))) throw std::runtime_error("cannot write " + file);
    const auto* pixels = outputs[1].data<const float>();
    return std::vector<float>(pixels, pixels + 9);
  }

 private:
  chiasm::Method load(const std::string& name) const {
    chiasm::LoadOptions options;
    options.backend = backend_;
    options.fused = false;  // onnx with standard operators: native code is the other backend
    return chiasm::Bundle::open(folder_ + "/registration." + name + ".chiasm").method("forward", options);
  }

  const std::string folder_, backend_;
  const chiasm::Method pyramid_ = load("pyramid"), step_ = load("step"), warp_ = load("warp");
  Matrix homography_ = kIdentity;
};

cv::Mat read(const std::string& file) {
  cv::Mat frame = cv::imread(file, cv::IMREAD_COLOR);
  if (frame.empty()) throw std::runtime_error("cannot read " + file);
  return frame;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 9) {
    std::cerr << "usage: study_registration BUNDLES native|onnx THREADS ITERATIONS LR SOURCE DESTINATION "
                 "WARPED\n";
    return 2;
  }
  chiasm::set_num_threads(std::stoi(argv[3]));
  const cv::Mat source = read(argv[6]), destination = read(argv[7]);
  if (source.size() != destination.size()) throw std::runtime_error("SOURCE and DESTINATION differ in size");
  Registration registration(argv[1], argv[2]);
  const std::clock_t start = std::clock();
  json report{{"levels", registration.descend(source, destination, std::stoi(argv[4]), std::stof(argv[5]))}};
  report["ms"] = 1000.0 * double(std::clock() - start) / CLOCKS_PER_SEC;
  report["pixels"] = registration.warp(source, argv[8]);
  report["torch"] = loaded("libtorch");
  std::cout << report << '\n';
  return 0;
} catch (const std::exception& error) {
  std::cerr << "study_registration: " << error.what() << '\n';
  return 1;
}
