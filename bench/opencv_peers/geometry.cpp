// OpenCV's peers of the ops of `geometry`: resizing and warping images, models of point pairs, rotations.
#include <opencv2/calib3d.hpp>

#include "batch.hpp"

namespace peers {
namespace {

auto resize(int interpolation) {
  return [=](const Inputs& x) {
    const cv::Size size(int(x[1].shape()[1]), int(x[1].shape()[0]));
    return per_image(images(x[0]),
                     [=](Batch& b, size_t i) { cv::resize(b.in[i], b.out[i], size, 0, 0, interpolation); });
  };
}

auto warp(int interpolation, int border) {
  return [=](const Inputs& x) {
    const cv::Size size(int(x[2].shape()[1]), int(x[2].shape()[0]));
    const cv::Mat m(3, 3, CV_32F, const_cast<void*>(x[1].data()));
    return per_image(images(x[0]), [=](Batch& b, size_t i) {
      cv::warpPerspective(b.in[i], b.out[i], m, size, interpolation, border);
    });
  };
}

Peer affine(const Inputs& x) {
  const cv::Size size(int(x[2].shape()[1]), int(x[2].shape()[0]));
  const cv::Mat m(2, 3, CV_32F, const_cast<void*>(x[1].data()));
  return per_image(images(x[0]), [=](Batch& b, size_t i) { cv::warpAffine(b.in[i], b.out[i], m, size); });
}

Peer remap(const Inputs& x) {
  const auto map = [&](const chiasm::Tensor& t) {
    return cv::Mat(int(t.shape()[1]), int(t.shape()[2]), CV_32F, const_cast<void*>(t.data()));
  };
  const cv::Mat column = map(x[1]), row = map(x[2]);  // the same for each image
  return per_image(images(x[0]),
                   [=](Batch& b, size_t i) { cv::remap(b.in[i], b.out[i], column, row, cv::INTER_LINEAR); });
}

Peer undistort(const Inputs& x) {
  const cv::Mat camera(3, 3, CV_32F, const_cast<void*>(x[1].data())),
      lens(1, int(x[2].shape()[1]), CV_32F, const_cast<void*>(x[2].data()));
  return per_image(images(x[0]), [=](Batch& b, size_t i) { cv::undistort(b.in[i], b.out[i], camera, lens); });
}

Peer half(const Inputs& x) {
  return per_image(images(x[0]), [](Batch& b, size_t i) { cv::pyrDown(b.in[i], b.out[i]); });
}

// Calls body(matrices) for each entry of the batch, with the inputs' rows as matrices with `channels`
// channels.
template <class Body>
Peer per_entry(const Inputs& x, std::vector<int> rows, std::vector<int> channels, Body body) {
  std::vector<std::vector<cv::Mat>> entries(size_t(x[0].shape()[0]));
  for (size_t i = 0; i < entries.size(); ++i)
    for (size_t k = 0; k < rows.size(); ++k) {
      const int64_t values = x[k].shape().count() / x[k].shape()[0],
                    n = rows[k] ? rows[k] : values / channels[k];
      auto* data = const_cast<float*>(x[k].data<const float>()) + int64_t(i) * values;
      entries[i].emplace_back(int(n), int(values / n / channels[k]), CV_32FC(channels[k]), data);
    }
  return {[entries, body] {
            for (const auto& e : entries) body(e);
          },
          {}};
}

Peer homography(const Inputs& x) {
  return per_entry(x, {0, 0}, {2, 2}, [](const std::vector<cv::Mat>& m) { cv::findHomography(m[0], m[1]); });
}

// A confidence so high that all samples are drawn.
constexpr double kConfidence = 1 - 1e-15;

Peer robust_homography(const Inputs& x) {
  const int samples = int(x[2].shape()[1]);
  return per_entry(x, {0, 0}, {2, 2}, [=](const std::vector<cv::Mat>& m) {
    cv::findHomography(m[0], m[1], cv::RANSAC, 3.0, cv::noArray(), samples, kConfidence);
  });
}

Peer robust_fundamental(const Inputs& x) {
  const int samples = int(x[2].shape()[1]);
  return per_entry(x, {0, 0}, {2, 2}, [=](const std::vector<cv::Mat>& m) {
    cv::findFundamentalMat(m[0], m[1], cv::FM_RANSAC, 1.0, kConfidence, samples);
  });
}

Peer robust_essential(const Inputs& x) {
  const int samples = int(x[4].shape()[1]);
  return per_entry(x, {0, 0, 3}, {2, 2, 1}, [=](const std::vector<cv::Mat>& m) {
    cv::findEssentialMat(m[0], m[1], m[2], cv::RANSAC, kConfidence, 1.0, samples);
  });
}

Peer four_points(const Inputs& x) {
  return per_entry(x, {0, 0}, {2, 2},
                   [](const std::vector<cv::Mat>& m) { cv::getPerspectiveTransform(m[0], m[1]); });
}

Peer decomposed(const Inputs& x) {
  return per_entry(x, {3}, {1}, [](const std::vector<cv::Mat>& m) {
    cv::Mat r1, r2, t;
    cv::decomposeEssentialMat(m[0], r1, r2, t);
  });
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
      {"geometry.transform.warp_perspective.bilinear_reflection",
       warp(cv::INTER_LINEAR, cv::BORDER_REFLECT_101)},
      {"geometry.transform.warp_perspective.nearest_zeros", warp(cv::INTER_NEAREST, cv::BORDER_CONSTANT)},
      {"geometry.transform.warp_perspective.nearest_border", warp(cv::INTER_NEAREST, cv::BORDER_REPLICATE)},
      {"geometry.transform.warp_affine.bilinear_zeros", affine},
      {"geometry.transform.remap.bilinear_zeros", remap},
      {"geometry.transform.pyrdown.by_2", half},
      {"geometry.transform.get_perspective_transform", four_points},
      {"geometry.calibration.undistort_image", undistort},
      {"geometry.homography.find_homography_dlt", homography},
      {"geometry.ransac.ransac_homography", robust_homography},
      {"geometry.ransac.ransac_fundamental", robust_fundamental},
      {"geometry.ransac.ransac_essential", robust_essential},
      {"geometry.epipolar.decompose_essential_matrix", decomposed},
      {"geometry.conversions.axis_angle_to_rotation_matrix", rodrigues},
      {"geometry.conversions.rotation_matrix_to_axis_angle", rodrigues},
  };
}

}  // namespace peers
