// Two image files matched by the exported bundle, without Python.
//
//     study_attack BUNDLE native|onnx|torch SAMPLES IMAGE1 IMAGE2
//
// Prints JSON: the homography from IMAGE1 to IMAGE2, the number of inliers, the matches (x y of image 1, x y
// of image 2), and whether each is an inlier. RANSAC uses SAMPLES samples, drawn by a Mersenne twister, so
// that Python draws the same ones.
#include <algorithm>
#include <cstdint>
#include <iostream>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <chiasm/chiasm.hpp>
#include <chiasm/opencv.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

using nlohmann::json;

namespace {

constexpr uint32_t kSeed = 1;

cv::Mat read(const std::string& path) {
  cv::Mat image = cv::imread(path, cv::IMREAD_COLOR);
  if (image.empty()) throw std::runtime_error("cannot read the image " + path);
  return image;
}

// The upper 24 bits, which a float holds exactly.
std::vector<float> uniforms(int64_t samples) {
  std::mt19937 random(kSeed);
  std::vector<float> numbers(size_t(samples) * 4);
  for (float& number : numbers) number = float(random() >> 8) * 0x1p-24f;
  return numbers;
}

json match(const std::string& bundle, const std::string& backend, int64_t samples, const cv::Mat& first,
           const cv::Mat& second) {
  chiasm::LoadOptions options;
  options.backend = backend;
  options.fused = false;  // onnx with ONNX Runtime's own operators
  auto method = chiasm::Bundle::open(bundle).method("forward", options);
  std::vector<float> numbers = uniforms(samples);
  const auto results =
      method.run({chiasm::view(first), chiasm::view(second), chiasm::Tensor(numbers.data(), {samples, 4})});
  const auto *h = results[0].data<const float>(), *p = results[1].data<const float>(),
             *q = results[2].data<const float>();
  const auto *matched = results[3].data<const bool>(), *inlier = results[4].data<const bool>();
  json matches = json::array(), inliers = json::array();
  for (int64_t i = 0; i < results[3].shape()[0]; ++i)
    if (matched[i]) {
      matches.push_back({p[2 * i], p[2 * i + 1], q[2 * i], q[2 * i + 1]});
      inliers.push_back(inlier[i]);
    }
  const auto count = std::count(inlier, inlier + results[4].shape()[0], true);
  return {{"backend", method.backend()},
          {"homography", std::vector<float>(h, h + 9)},
          {"inlier_count", count},
          {"matches", matches},
          {"inliers", inliers}};
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 6) {
    std::cerr << "usage: study_attack BUNDLE native|onnx|torch SAMPLES IMAGE1 IMAGE2\n";
    return 2;
  }
  const int64_t samples = std::stoll(argv[3]);
  if (samples < 1)
    throw std::runtime_error("SAMPLES: expected a positive number, got " + std::string(argv[3]));
  std::cout << match(argv[1], argv[2], samples, read(argv[4]), read(argv[5])) << std::endl;
  return 0;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
