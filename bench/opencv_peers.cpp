#include "opencv_peers.hpp"

#include <array>
#include <memory>

#include <opencv2/calib3d.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

namespace peers {
namespace {

using Call = std::function<void()>;
using Inputs = std::vector<chiasm::Tensor>;

// The images of a batch (B, C, H, W) as HWC matrices, and room for results.
struct Batch {
  std::vector<cv::Mat> in, out, scratch, more;

  explicit Batch(const chiasm::Tensor& tensor) {
    const auto& s = tensor.shape();
    const float* data = tensor.data<const float>();
    for (int64_t b = 0; b < s[0]; ++b) {
      std::vector<cv::Mat> planes;
      for (int64_t c = 0; c < s[1]; ++c)
        planes.emplace_back(int(s[2]), int(s[3]), CV_32F, const_cast<float*>(data + (b * s[1] + c) * s[2] * s[3]));
      in.emplace_back();
      cv::merge(planes, in.back());
    }
    out.resize(in.size());
    scratch.resize(in.size());
    more.resize(in.size());
  }
};

template <class Body>
Call per_image(const chiasm::Tensor& tensor, Body body) {
  auto batch = std::make_shared<Batch>(tensor);
  return [batch, body] {
    for (size_t i = 0; i < batch->in.size(); ++i) body(*batch, i);
  };
}

cv::Mat frame(const chiasm::Tensor& tensor) {
  return cv::Mat(int(tensor.shape()[0]), int(tensor.shape()[1]), CV_8UC3, const_cast<void*>(tensor.data()));
}

Call sobel(const Inputs& x) {
  return per_image(x[0], [](Batch& b, size_t i) {
    cv::Sobel(b.in[i], b.scratch[i], CV_32F, 1, 0, 3, 1.0 / 8, 0, cv::BORDER_REPLICATE);
    cv::Sobel(b.in[i], b.more[i], CV_32F, 0, 1, 3, 1.0 / 8, 0, cv::BORDER_REPLICATE);
    cv::magnitude(b.scratch[i].reshape(1), b.more[i].reshape(1), b.out[i]);
  });
}

Call gaussian(const Inputs& x) {
  const double sigma = x[1].data<const float>()[0];
  return per_image(x[0], [sigma](Batch& b, size_t i) { cv::GaussianBlur(b.in[i], b.out[i], {5, 5}, sigma, sigma, cv::BORDER_REFLECT_101); });
}

Call edges(const Inputs& x) {
  auto buffers = std::make_shared<std::array<cv::Mat, 6>>();
  const cv::Mat input = frame(x[0]);
  return [buffers, input] {
    auto& [grey, blurred, dx, dy, magnitude, out] = *buffers;
    cv::cvtColor(input, grey, cv::COLOR_BGR2GRAY);
    cv::GaussianBlur(grey, blurred, {5, 5}, 1.0);
    cv::Sobel(blurred, dx, CV_32F, 1, 0);
    cv::Sobel(blurred, dy, CV_32F, 0, 1);
    cv::magnitude(dx, dy, magnitude);
    magnitude.convertTo(out, CV_8U);
  };
}

Call preprocess(const Inputs& x) {
  auto small = std::make_shared<cv::Mat>();
  auto blob = std::make_shared<cv::Mat>();
  const cv::Mat input = frame(x[0]);
  return [small, blob, input] {
    cv::resize(input, *small, {224, 224}, 0, 0, cv::INTER_LINEAR);
    cv::dnn::blobFromImage(*small, *blob, 1.0 / (255 * 0.226), {}, {123.675, 116.28, 103.53}, true);
  };
}

Call resize(const Inputs& x, int interpolation) {
  const cv::Size size(int(x[1].shape()[1]), int(x[1].shape()[0]));
  return per_image(x[0], [size, interpolation](Batch& b, size_t i) { cv::resize(b.in[i], b.out[i], size, 0, 0, interpolation); });
}

Call warp(const Inputs& x, int interpolation, int border) {
  const cv::Size size(int(x[2].shape()[1]), int(x[2].shape()[0]));
  const cv::Mat m(3, 3, CV_32F, const_cast<void*>(x[1].data()));
  return per_image(x[0], [=](Batch& b, size_t i) { cv::warpPerspective(b.in[i], b.out[i], m, size, interpolation, border); });
}

Call homography(const Inputs& x) {
  const int n = int(x[0].shape()[1]);
  const cv::Mat a(n, 1, CV_32FC2, const_cast<void*>(x[0].data())), b(n, 1, CV_32FC2, const_cast<void*>(x[1].data()));
  return [a, b] { cv::findHomography(a, b); };
}

Call rodrigues(const Inputs& x) {
  const int64_t n = x[0].shape()[0], width = x[0].shape().size() == 3 ? 9 : 3;
  const float* data = x[0].data<const float>();
  auto out = std::make_shared<cv::Mat>();
  return [=] {
    for (int64_t i = 0; i < n; ++i) {
      float* row = const_cast<float*>(data + i * width);
      cv::Rodrigues(width == 9 ? cv::Mat(3, 3, CV_32F, row) : cv::Mat(3, 1, CV_32F, row), *out);
    }
  };
}

}  // namespace

std::optional<Call> opencv(const std::string& bundle, const Inputs& x) {
  if (bundle == "color.rgb_to_grayscale") return per_image(x[0], [](Batch& b, size_t i) { cv::cvtColor(b.in[i], b.out[i], cv::COLOR_RGB2GRAY); });
  if (bundle == "color.rgb_to_hsv") return per_image(x[0], [](Batch& b, size_t i) { cv::cvtColor(b.in[i], b.out[i], cv::COLOR_RGB2HSV); });
  if (bundle == "enhance.normalize")
    return per_image(x[0], [](Batch& b, size_t i) {
      cv::subtract(b.in[i], cv::Scalar(0.485, 0.456, 0.406), b.scratch[i]);
      cv::divide(b.scratch[i], cv::Scalar(0.229, 0.224, 0.225), b.out[i]);
    });
  if (bundle == "filters.sobel") return sobel(x);
  if (bundle == "filters.gaussian_blur2d") return gaussian(x);
  if (bundle == "filters.median_blur") return per_image(x[0], [](Batch& b, size_t i) { cv::medianBlur(b.in[i], b.out[i], 3); });
  if (bundle == "filters.bilateral_blur") return per_image(x[0], [](Batch& b, size_t i) { cv::bilateralFilter(b.in[i], b.out[i], 5, 0.1, 1.5); });
  if (bundle == "morphology.dilation") {
    const cv::Mat cross = cv::getStructuringElement(cv::MORPH_CROSS, {3, 3});
    return per_image(x[0], [cross](Batch& b, size_t i) { cv::dilate(b.in[i], b.out[i], cross); });
  }
  if (bundle == "geometry.transform.resize.bilinear") return resize(x, cv::INTER_LINEAR);
  if (bundle == "geometry.transform.resize.bicubic") return resize(x, cv::INTER_CUBIC);
  if (bundle == "geometry.transform.resize.nearest") return resize(x, cv::INTER_NEAREST);
  if (bundle == "geometry.transform.resize.bilinear_antialias") return resize(x, cv::INTER_AREA);
  if (bundle == "geometry.transform.warp_perspective.bilinear_zeros") return warp(x, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  if (bundle == "geometry.transform.warp_perspective.bilinear_border") return warp(x, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  if (bundle == "geometry.transform.warp_perspective.bilinear_reflection") return warp(x, cv::INTER_LINEAR, cv::BORDER_REFLECT_101);
  if (bundle == "geometry.transform.warp_perspective.nearest_zeros") return warp(x, cv::INTER_NEAREST, cv::BORDER_CONSTANT);
  if (bundle == "geometry.transform.warp_perspective.nearest_border") return warp(x, cv::INTER_NEAREST, cv::BORDER_REPLICATE);
  if (bundle == "geometry.homography.find_homography_dlt") return homography(x);
  if (bundle == "geometry.conversions.axis_angle_to_rotation_matrix" || bundle == "geometry.conversions.rotation_matrix_to_axis_angle") return rodrigues(x);
  if (bundle == "pipelines.edges") return edges(x);
  if (bundle == "pipelines.preprocess") return preprocess(x);
  return std::nullopt;
}

}  // namespace peers
