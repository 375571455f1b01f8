// OpenCV's peers of the ops of `enhance`: arithmetic, thresholds, histograms, sums.
#include "batch.hpp"

namespace peers {
namespace {

Peer normalize(const Inputs& x) {
  const cv::Scalar mean = channels(x[1]), std = channels(x[2]);
  return per_image(images(x[0]), [mean, std](Batch& b, size_t i) {
    cv::subtract(b.in[i], mean, b.scratch[i]);
    cv::divide(b.scratch[i], std, b.out[i]);
  });
}

Peer add_weighted(const Inputs& x) {
  const auto others = images(x[2]);
  const double alpha = first(x[1]), beta = first(x[3]), gamma = first(x[4]);
  return per_image(images(x[0]), [=](Batch& b, size_t i) {
    cv::addWeighted(b.in[i], alpha, others[i], beta, gamma, b.out[i]);
  });
}

// Without the gain, which is 1, and without clamping, which has no effect here.
Peer adjust_gamma(const Inputs& x) {
  const double gamma = first(x[1]);
  return per_image(images(x[0]), [gamma](Batch& b, size_t i) { cv::pow(b.in[i], gamma, b.out[i]); });
}

Peer threshold(const Inputs& x) {
  const double limit = first(x[1]), value = first(x[2]);
  return per_image(images(x[0]), [=](Batch& b, size_t i) {
    cv::threshold(b.in[i], b.out[i], limit, value, cv::THRESH_BINARY);
  });
}

Peer equalize(const Inputs& x) {
  return per_byte_image(planes(x[0]), 255,
                        [](const cv::Mat& in, cv::Mat& out, cv::Mat&) { cv::equalizeHist(in, out); });
}

Peer clahe(const Inputs& x) {
  const auto made = cv::createCLAHE(4.0, {4, 3});
  return per_image(byte_planes(x[0], 255), [made](Batch& b, size_t i) { made->apply(b.in[i], b.out[i]); });
}

Peer integral(const Inputs& x) {
  return per_image(images(x[0]), [](Batch& b, size_t i) { cv::integral(b.in[i], b.out[i], CV_32F); });
}

}  // namespace

Table enhance() {
  return {
      {"enhance.normalize", normalize},       {"enhance.add_weighted", add_weighted},
      {"enhance.adjust_gamma", adjust_gamma}, {"enhance.threshold.binary", threshold},
      {"enhance.equalize", equalize},         {"enhance.clahe", clahe},
      {"enhance.integral_image", integral},
  };
}

}  // namespace peers
