// Kernels of bytes, in planes and in frames: against OpenCV, to the bit.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "benchmarks.h"
#include "fixture.h"
#include "kernels.h"

using namespace chiasm::kernels;

namespace {

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

int cv_border(Border border) {
  switch (border) {
    case Border::kReplicate: return cv::BORDER_REPLICATE;
    case Border::kConstant: return cv::BORDER_CONSTANT;
    default: return cv::BORDER_REFLECT_101;
  }
}

// Rounded to multiples of 1/256, each error carried on to the next tap inwards: the middle first.
std::vector<int32_t> fixed_gaussian(int radius, double sigma) {
  std::vector<double> taps;
  for (int i = -radius; i <= radius; ++i) taps.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
  const double total = std::accumulate(taps.begin(), taps.end(), 0.0);
  std::vector<int32_t> fixed(static_cast<size_t>(radius) + 1);
  double error = 0;
  int32_t sum = 0;
  for (int i = 0; i < radius; ++i) {
    const double wanted = taps[static_cast<size_t>(i)] / total * 256 + error;
    const auto tap = static_cast<int32_t>(std::lrint(wanted));
    error = wanted - tap;
    fixed[static_cast<size_t>(radius - i)] = tap;
    sum += 2 * tap;
  }
  fixed[0] = 256 - sum;
  return fixed;
}

// All taps of those from the middle to the end.
std::vector<double> full(const std::vector<int32_t>& taps) {
  std::vector<double> all(taps.rbegin(), taps.rend());
  all.insert(all.end(), taps.begin() + 1, taps.end());
  return all;
}

TEST_F(Bytes, SeparableMatchesOpenCvGaussian) {
  for (const Size& size : kSizes)
    for (const int channels : {1, 3, 4})
      for (const int radius : {0, 1, 2, 3, 10})
        for (const Border border : {Border::kReflect, Border::kReplicate, Border::kConstant}) {
          if (border == Border::kReflect && std::min(size.height, size.width) <= radius) continue;
          const double sigma = 0.3 + 0.35 * radius;
          const auto taps = fixed_gaussian(radius, sigma);
          const cv::Mat image = frame(size.height, size.width, channels);
          cv::Mat expected, out(image.size(), image.type());
          cv::sepFilter2D(image, expected, CV_64F, full(taps), full(taps), {-1, -1}, 0, cv_border(border));
          separable_bytes(image.data, 1, size.height, size.width * channels, taps.data(), 1, radius + 1,
                          taps.data(), 1, radius + 1, channels, border, out.data);
          for (int y = 0; y < size.height; ++y)
            for (int i = 0; i < size.width * channels; ++i)
              ASSERT_EQ(out.ptr<uint8_t>(y)[i], std::floor(expected.ptr<double>(y)[i] / 65536 + 0.5))
                  << size.height << " x " << size.width << " x " << channels << ", radius " << radius;
        }
}

// A frame of 1080 x 1920 x 3, and room for as much.
struct Frame {
  std::vector<uint8_t> x = std::vector<uint8_t>(1080 * 1920 * 3), out = std::vector<uint8_t>(x.size());
  Frame() {
    std::mt19937 engine(1);
    for (uint8_t& value : x) value = static_cast<uint8_t>(engine());
  }
};

template <int kRadius>
void gaussian(Frame& frame) {
  static const std::vector<int32_t> taps = fixed_gaussian(kRadius, 0.3 + 0.35 * kRadius);
  separable_bytes(frame.x.data(), 1, 1080, 1920 * 3, taps.data(), 1, kRadius + 1, taps.data(), 1, kRadius + 1,
                  3, Border::kReflect, frame.out.data());
}
KERNEL_CALL_BENCHMARK(separable_bytes_5x5,
                      [] { return [frame = Frame()]() mutable { gaussian<2>(frame); }; });
KERNEL_CALL_BENCHMARK(separable_bytes_21x21,
                      [] { return [frame = Frame()]() mutable { gaussian<10>(frame); }; });

}  // namespace
