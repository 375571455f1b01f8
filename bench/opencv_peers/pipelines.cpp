// OpenCV's calls for the same work as two pipelines: the edges of a frame, and a network's input.
#include <array>

#include <opencv2/dnn.hpp>

#include "batch.hpp"

namespace peers {
namespace {

Peer edges(const Inputs& x) {
  auto buffers = std::make_shared<std::array<cv::Mat, 6>>();
  const cv::Mat input = frame(x[0]);
  const auto call = [buffers, input] {
    auto& [grey, blurred, dx, dy, magnitude, out] = *buffers;
    cv::cvtColor(input, grey, cv::COLOR_BGR2GRAY);
    cv::GaussianBlur(grey, blurred, {5, 5}, 1.0);
    cv::Sobel(blurred, dx, CV_32F, 1, 0);
    cv::Sobel(blurred, dy, CV_32F, 0, 1);
    cv::magnitude(dx, dy, magnitude);
    magnitude.convertTo(out, CV_8U);
  };
  return {call, {}};
}

Peer preprocess(const Inputs& x) {
  auto small = std::make_shared<cv::Mat>();
  auto blob = std::make_shared<cv::Mat>();
  const cv::Mat input = frame(x[0]);
  const auto call = [small, blob, input] {
    cv::resize(input, *small, {224, 224}, 0, 0, cv::INTER_LINEAR);
    cv::dnn::blobFromImage(*small, *blob, 1.0 / (255 * 0.226), {}, {123.675, 116.28, 103.53}, true);
  };
  return {call, {}};
}

}  // namespace

Table pipelines() { return {{"pipelines.edges", edges}, {"pipelines.preprocess", preprocess}}; }

}  // namespace peers
