// Two views of a scene, matched by chiasm's native code and by OpenCV; `python -m bench.matching` calls this
// and scores its output.
//
//     bench_matching PIPELINE DETECTOR THREADS TURNS IMAGE1 IMAGE2 [IMAGE1 IMAGE2 ...]
//
// For each pair of image files, it prints a line of JSON. For each contender, this has the homography, the
// matches (x y of image 1, x y of image 2), the key points of both images, and the median milliseconds of
// TURNS calls. The contenders' calls alternate.
#include <iostream>
#include <optional>
#include <random>
#include <string>

#include <chiasm/chiasm.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>

#include "../harness.hpp"

using nlohmann::json;

namespace {

constexpr int kKeyPoints = 2500, kSamples = 1000;

struct Answer {
  json homography = nullptr, matches = json::array(), keypoints1 = json::array(), keypoints2 = json::array();
};

class Chiasm {
 public:
  Chiasm(const std::string& pipeline, const std::string& detector)
      : pipeline_(load(pipeline)), detector_(load(detector)), uniforms_(size_t{kSamples} * 4) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (float& u : uniforms_) u = uniform(random);
  }

  // Takes bytes, as from a file: the conversion is measured too.
  void match(const cv::Mat& first, const cv::Mat& second) {
    first.convertTo(images_[0], CV_32F, 1 / 255.0);
    second.convertTo(images_[1], CV_32F, 1 / 255.0);
    const chiasm::Tensor uniforms(uniforms_.data(), chiasm::DType::Float32, chiasm::Shape({1, kSamples, 4}));
    results_.emplace(pipeline_.run({tensor(images_[0]), tensor(images_[1]), uniforms}));
  }

  Answer answer() {
    Answer a;
    const chiasm::Outputs& results = *results_;
    const auto* h = results[0].data<const float>();
    a.homography = std::vector<float>(h, h + 9);
    const auto *p = results[1].data<const float>(), *q = results[2].data<const float>();
    for (int64_t i = 0; i < results[3].shape()[1]; ++i)
      if (results[3].data<const bool>()[i])
        a.matches.push_back({p[2 * i], p[2 * i + 1], q[2 * i], q[2 * i + 1]});
    a.keypoints1 = keypoints(images_[0]);
    a.keypoints2 = keypoints(images_[1]);
    return a;
  }

 private:
  static chiasm::Method load(const std::string& path) {
    return chiasm::Bundle::open(path).method("forward", chiasm::LoadOptions().with_backend("native"));
  }

  static chiasm::Tensor tensor(cv::Mat& m) {
    return chiasm::Tensor(m.ptr<float>(), chiasm::DType::Float32, chiasm::Shape({1, 1, m.rows, m.cols}));
  }

  json keypoints(cv::Mat& image) {
    const auto found = detector_.run({tensor(image)});
    const auto* laf = found[0].data<const float>();
    json points = json::array();
    for (int64_t i = 0; i < found[2].shape()[1]; ++i)
      if (found[2].data<const bool>()[i]) points.push_back({laf[6 * i + 2], laf[6 * i + 5]});
    return points;
  }

  chiasm::Method pipeline_, detector_;
  std::vector<float> uniforms_;
  cv::Mat images_[2];
  std::optional<chiasm::Outputs> results_;
};

// The method in OpenCV's documentation: the ratio test of the two nearest neighbours, then RANSAC.
class OpenCv {
 public:
  void match(const cv::Mat& first, const cv::Mat& second) {
    cv::Mat descriptors[2];
    sift_->detectAndCompute(first, cv::noArray(), keypoints_[0], descriptors[0]);
    sift_->detectAndCompute(second, cv::noArray(), keypoints_[1], descriptors[1]);
    std::vector<std::vector<cv::DMatch>> nearest;
    matcher_.knnMatch(descriptors[0], descriptors[1], nearest, 2);
    points_[0].clear();
    points_[1].clear();
    for (const auto& two : nearest)
      if (two.size() == 2 && two[0].distance < 0.8f * two[1].distance) {
        points_[0].push_back(keypoints_[0][size_t(two[0].queryIdx)].pt);
        points_[1].push_back(keypoints_[1][size_t(two[0].trainIdx)].pt);
      }
    homography_ =
        points_[0].size() < 4 ? cv::Mat() : cv::findHomography(points_[0], points_[1], cv::RANSAC, 3.0);
  }

  Answer answer() const {
    Answer a;
    if (!homography_.empty())
      a.homography = std::vector<double>(homography_.begin<double>(), homography_.end<double>());
    for (size_t i = 0; i < points_[0].size(); ++i)
      a.matches.push_back({points_[0][i].x, points_[0][i].y, points_[1][i].x, points_[1][i].y});
    for (const auto& k : keypoints_[0]) a.keypoints1.push_back({k.pt.x, k.pt.y});
    for (const auto& k : keypoints_[1]) a.keypoints2.push_back({k.pt.x, k.pt.y});
    return a;
  }

 private:
  cv::Ptr<cv::SIFT> sift_ = cv::SIFT::create(kKeyPoints);
  cv::BFMatcher matcher_{cv::NORM_L2};
  std::vector<cv::KeyPoint> keypoints_[2];
  std::vector<cv::Point2f> points_[2];
  cv::Mat homography_;
};

json described(const Answer& a, std::vector<double> times) {
  return {{"homography", a.homography},
          {"matches", a.matches},
          {"keypoints1", a.keypoints1},
          {"keypoints2", a.keypoints2},
          {"ms", bench::median(std::move(times)) / 1000}};
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 7 || argc % 2 == 0) {
    std::cerr << "usage: bench_matching PIPELINE DETECTOR THREADS TURNS IMAGE1 IMAGE2 [IMAGE1 IMAGE2 ...]\n";
    return 2;
  }
  const int threads = std::stoi(argv[3]);
  chiasm::set_num_threads(threads);
  cv::setNumThreads(threads);
  Chiasm ours(argv[1], argv[2]);
  OpenCv theirs;
  for (int i = 5; i < argc; i += 2) {
    const cv::Mat first = cv::imread(argv[i], cv::IMREAD_GRAYSCALE),
                  second = cv::imread(argv[i + 1], cv::IMREAD_GRAYSCALE);
    if (first.empty() || second.empty())
      throw std::runtime_error(std::string("cannot read ") + argv[i] + " or " + argv[i + 1]);
    std::vector<double> our_times, their_times;
    for (int turn = 0; turn < std::stoi(argv[4]); ++turn) {
      bench::rest(threads);
      auto start = bench::Clock::now();
      ours.match(first, second);
      our_times.push_back(bench::microseconds_since(start));
      bench::rest(threads);
      start = bench::Clock::now();
      theirs.match(first, second);
      their_times.push_back(bench::microseconds_since(start));
    }
    std::cout << json{{"chiasm", described(ours.answer(), our_times)},
                      {"OpenCV", described(theirs.answer(), their_times)},
                      {"opencv_version", CV_VERSION}}
              << std::endl;
  }
  return 0;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
