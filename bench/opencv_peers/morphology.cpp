// OpenCV's peers of the ops of `morphology`.
#include "batch.hpp"

namespace peers {
namespace {

auto morphology(int operation, int shape, int size) {
  return [=](const Inputs& x) {
    const cv::Mat element = cv::getStructuringElement(shape, {size, size});
    return per_image(images(x[0]),
                     [=](Batch& b, size_t i) { cv::morphologyEx(b.in[i], b.out[i], operation, element); });
  };
}

}  // namespace

Table morphology() {
  return {
      {"morphology.dilation", morphology(cv::MORPH_DILATE, cv::MORPH_CROSS, 3)},
      {"morphology.gradient", morphology(cv::MORPH_GRADIENT, cv::MORPH_CROSS, 3)},
      {"morphology.max_filter2d", morphology(cv::MORPH_DILATE, cv::MORPH_RECT, 5)},
  };
}

}  // namespace peers
