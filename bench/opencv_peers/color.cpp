// OpenCV's peers of chiasm's colour conversions.
#include "batch.hpp"

namespace peers {
namespace {

auto convert(int code) {
  return [code](const Inputs& x) {
    return per_image(images(x[0]), [code](Batch& b, size_t i) { cv::cvtColor(b.in[i], b.out[i], code); });
  };
}

}  // namespace

Table color() {
  return {
      {"color.rgb_to_grayscale", convert(cv::COLOR_RGB2GRAY)},
      {"color.rgb_to_hsv", convert(cv::COLOR_RGB2HSV)},
      {"color.rgb_to_lab", convert(cv::COLOR_RGB2Lab)},
      {"color.rgb_to_ycbcr", convert(cv::COLOR_RGB2YCrCb)},
      {"color.rgb_to_yuv", convert(cv::COLOR_RGB2YUV)},
  };
}

}  // namespace peers
