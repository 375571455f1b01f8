// OpenCV's peers of the ops of `filters`: gradients, blurs, thresholds, Canny.
#include "batch.hpp"

namespace peers {
namespace {

constexpr int REFLECT = cv::BORDER_REFLECT_101;

Peer sobel(const Inputs& x) {
  return per_image(images(x[0]), [](Batch& b, size_t i) {
    cv::Sobel(b.in[i], b.scratch[i], CV_32F, 1, 0, 3, 1.0 / 8, 0, cv::BORDER_REPLICATE);
    cv::Sobel(b.in[i], b.more[i], CV_32F, 0, 1, 3, 1.0 / 8, 0, cv::BORDER_REPLICATE);
    b.out[i].create(b.in[i].size(), b.in[i].type());
    cv::magnitude(b.scratch[i].reshape(1), b.more[i].reshape(1), b.out[i].reshape(1));
  });
}

Peer gaussian(const Inputs& x) {
  const double sigma = first(x[1]);
  return per_image(images(x[0]), [sigma](Batch& b, size_t i) {
    cv::GaussianBlur(b.in[i], b.out[i], {5, 5}, sigma, sigma, REFLECT);
  });
}

Peer unsharp(const Inputs& x) {
  return per_image(images(x[0]), [](Batch& b, size_t i) {
    cv::GaussianBlur(b.in[i], b.scratch[i], {5, 5}, 1.5, 1.5, REFLECT);
    cv::addWeighted(b.in[i], 2, b.scratch[i], -1, 0, b.out[i]);
  });
}

Peer correlate(const Inputs& x, const cv::Mat& kernel) {
  return per_image(images(x[0]), [kernel](Batch& b, size_t i) {
    cv::filter2D(b.in[i], b.out[i], CV_32F, kernel, {-1, -1}, 0, REFLECT);
  });
}

Peer laplacian(const Inputs& x) {
  cv::Mat kernel(3, 3, CV_32F, cv::Scalar(1.0 / 16));
  kernel.at<float>(1, 1) = -0.5f;
  return correlate(x, kernel);
}

Peer filter2d(const Inputs& x) {
  return correlate(x, cv::Mat(3, 3, CV_32F, const_cast<float*>(x[1].data<const float>())));
}

Peer box(const Inputs& x) {
  return per_image(images(x[0]), [](Batch& b, size_t i) {
    cv::blur(b.in[i], b.out[i], {5, 5}, {-1, -1}, REFLECT);
  });
}

Peer median(const Inputs& x) {
  return per_image(images(x[0]), [](Batch& b, size_t i) { cv::medianBlur(b.in[i], b.out[i], 3); });
}

Peer bilateral(const Inputs& x) {
  return per_image(images(x[0]),
                   [](Batch& b, size_t i) { cv::bilateralFilter(b.in[i], b.out[i], 5, 0.1, 1.5, REFLECT); });
}

Peer canny(const Inputs& x) {
  return per_byte_image(images(x[0]), 255, [](const cv::Mat& in, cv::Mat& out, cv::Mat& grey) {
    cv::cvtColor(in, grey, cv::COLOR_RGB2GRAY);
    cv::GaussianBlur(grey, grey, {5, 5}, 1, 1, REFLECT);
    cv::Canny(grey, out, 0.5 * 255, 0.9 * 255, 3, true);
  });
}

Peer adaptive(const Inputs& x) {
  return per_byte_image(planes(x[0]), 1, [](const cv::Mat& in, cv::Mat& out, cv::Mat&) {
    cv::adaptiveThreshold(in, out, 255, cv::ADAPTIVE_THRESH_MEAN_C, cv::THRESH_BINARY, 5, 2);
  });
}

// The threshold is found on bytes and applied to float32.
Peer otsu(const Inputs& x) {
  return per_image(planes(x[0]), [](Batch& b, size_t i) {
    b.in[i].convertTo(b.bytes[i], CV_8U, 255);
    const double limit = cv::threshold(b.bytes[i], b.more[i], 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
    cv::threshold(b.in[i], b.out[i], (limit + 0.5) / 255, 0, cv::THRESH_TOZERO);
  });
}

}  // namespace

Table filters() {
  return {
      {"filters.sobel", sobel},          {"filters.gaussian_blur2d", gaussian},
      {"filters.unsharp_mask", unsharp}, {"filters.laplacian", laplacian},
      {"filters.filter2d", filter2d},    {"filters.box_blur", box},
      {"filters.median_blur", median},   {"filters.bilateral_blur", bilateral},
      {"filters.canny", canny},          {"filters.adaptive_threshold", adaptive},
      {"filters.otsu_threshold", otsu},
  };
}

}  // namespace peers
