#include <opencv2/calib3d.hpp>

#include "batch.hpp"

namespace peers {
namespace {

auto resize(int interpolation) {
  return [=](const Inputs& x) {
    const cv::Size size(int(x[1].shape()[1]), int(x[1].shape()[0]));
    return per_image(images(x[0]), [=](Batch& b, size_t i) { cv::resize(b.in[i], b.out[i], size, 0, 0, interpolation); });
  };
}

auto warp(int interpolation, int border) {
  return [=](const Inputs& x) {
    const cv::Size size(int(x[2].shape()[1]), int(x[2].shape()[0]));
    const cv::Mat m(3, 3, CV_32F, const_cast<void*>(x[1].data()));
    return per_image(images(x[0]), [=](Batch& b, size_t i) { cv::warpPerspective(b.in[i], b.out[i], m, size, interpolation, border); });
  };
}

Peer homography(const Inputs& x) {
  const int n = int(x[0].shape()[1]);
  const cv::Mat a(n, 1, CV_32FC2, const_cast<void*>(x[0].data())), b(n, 1, CV_32FC2, const_cast<void*>(x[1].data()));
  return {[a, b] { cv::findHomography(a, b); }, {}};
}

Peer rodrigues(const Inputs& x) {
  const int64_t n = x[0].shape()[0], width = x[0].shape().size() == 3 ? 9 : 3;
  const float* data = x[0].data<const float>();
  auto out = std::make_shared<cv::Mat>();
  const auto call = [=] {
    for (int64_t i = 0; i < n; ++i) {
      float* row = const_cast<float*>(data + i * width);
      cv::Rodrigues(width == 9 ? cv::Mat(3, 3, CV_32F, row) : cv::Mat(3, 1, CV_32F, row), *out);
    }
  };
  return {call, {}};
}

}  // namespace

Table geometry() {
  return {
      {"geometry.transform.resize.bilinear", resize(cv::INTER_LINEAR)},
      {"geometry.transform.resize.bicubic", resize(cv::INTER_CUBIC)},
      {"geometry.transform.resize.nearest", resize(cv::INTER_NEAREST)},
      {"geometry.transform.resize.bilinear_antialias", resize(cv::INTER_AREA)},
      {"geometry.transform.warp_perspective.bilinear_zeros", warp(cv::INTER_LINEAR, cv::BORDER_CONSTANT)},
      {"geometry.transform.warp_perspective.bilinear_border", warp(cv::INTER_LINEAR, cv::BORDER_REPLICATE)},
      {"geometry.transform.warp_perspective.bilinear_reflection", warp(cv::INTER_LINEAR, cv::BORDER_REFLECT_101)},
      {"geometry.transform.warp_perspective.nearest_zeros", warp(cv::INTER_NEAREST, cv::BORDER_CONSTANT)},
      {"geometry.transform.warp_perspective.nearest_border", warp(cv::INTER_NEAREST, cv::BORDER_REPLICATE)},
      {"geometry.homography.find_homography_dlt", homography},
      {"geometry.conversions.axis_angle_to_rotation_matrix", rodrigues},
      {"geometry.conversions.rotation_matrix_to_axis_angle", rodrigues},
  };
}

}  // namespace peers
