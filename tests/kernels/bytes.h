// Shared parts of the tests of kernels of bytes: images, their sizes, and a frame for benchmarks.
#pragma once

#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "benchmarks.h"
#include "fixture.h"
#include "kernels.h"

using chiasm::kernels::Border;

class Bytes : public ::testing::Test {
 protected:
  void SetUp() override { use_threads(3); }

  cv::Mat frame(int height, int width, int channels) {
    cv::Mat image(height, width, CV_8UC(channels));
    for (int y = 0; y < height; ++y)
      for (int i = 0; i < width * channels; ++i) image.ptr<uint8_t>(y)[i] = static_cast<uint8_t>(engine_());
    return image;
  }

  std::mt19937 engine_{7};
};

struct Size {
  int height, width;
};
constexpr Size kSizes[] = {{1, 1}, {1, 9}, {9, 1}, {5, 7}, {16, 33}, {37, 70}, {130, 21}};

inline int cv_border(Border border) {
  switch (border) {
    case Border::kReplicate: return cv::BORDER_REPLICATE;
    case Border::kConstant: return cv::BORDER_CONSTANT;
    default: return cv::BORDER_REFLECT_101;
  }
}

// A frame of 1080 x 1920 x 3, and an output buffer of the same size.
struct Frame {
  std::vector<uint8_t> x = std::vector<uint8_t>(1080 * 1920 * 3), out = std::vector<uint8_t>(x.size());
  Frame() {
    std::mt19937 engine(1);
    for (uint8_t& value : x) value = static_cast<uint8_t>(engine());
  }
};
