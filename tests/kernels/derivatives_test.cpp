// First derivatives of bytes: against OpenCV.
#include <array>
#include <cmath>
#include <initializer_list>

#include "bytes.h"

namespace {

using namespace chiasm::kernels;

TEST_F(Bytes, DerivativesMatchOpenCv) {
  for (const Size& size : kSizes)
    for (const auto& [side, centre] :
         {std::pair(1, 2), std::pair(3, 10), std::pair(1, 1), std::pair(0, 128)}) {
      const cv::Mat image = frame(size.height, size.width, 1);
      std::vector<int16_t> out(2 * image.total());
      derivatives_of_bytes(image.data, 1, size.height, size.width, side, centre, out.data());
      const cv::Mat slope = (cv::Mat_<double>(3, 1) << -1, 0, 1),
                    smooth = (cv::Mat_<double>(3, 1) << side, centre, side);
      for (const int down : {0, 1}) {
        cv::Mat expected;
        cv::sepFilter2D(image, expected, CV_64F, down ? smooth : slope, down ? slope : smooth,
                        cv::Point(-1, -1), 0, cv::BORDER_REPLICATE);
        cv::Mat made;
        cv::Mat(image.size(), CV_16S, out.data() + static_cast<size_t>(down) * image.total())
            .convertTo(made, CV_64F);
        EXPECT_EQ(cv::norm(made, expected, cv::NORM_INF), 0) << image.size() << " " << down << " " << centre;
      }
    }
}

TEST_F(Bytes, MagnitudesMatchOpenCvAndRoots) {
  for (const Size& size : kSizes)
    for (const int channels : {1, 2, 3, 4, 17}) {
      cv::Mat image = frame(size.height, size.width, channels), dx, dy, made(image.size(), image.type());
      // Noise has gradients with lengths up to 1442; faint noise has short ones.
      for (int y = 0; y < (size.height + 1) / 2; ++y)
        for (int i = 0; i < size.width * channels; ++i) image.ptr<uint8_t>(y)[i] &= 7;
      const int64_t length = int64_t{size.width} * channels;
      const cv::Mat slope = (cv::Mat_<double>(3, 1) << -1, 0, 1);
      for (const auto& [side, centre, divisor] : std::initializer_list<std::array<int, 3>>{
               {1, 2, 8}, {1, 2, 1}, {1, 2, 6}, {3, 10, 32}, {3, 10, 1}, {1, 1, 6}, {16, 0, 64}, {0, 1, 2}}) {
        const cv::Mat smooth = (cv::Mat_<double>(3, 1) << side, centre, side);
        const cv::Point middle(-1, -1);
        cv::sepFilter2D(image, dx, CV_64F, slope, smooth, middle, 0, cv::BORDER_REPLICATE);
        cv::sepFilter2D(image, dy, CV_64F, smooth, slope, middle, 0, cv::BORDER_REPLICATE);
        magnitude_of_bytes(image.data, 1, size.height, length, channels, side, centre, divisor, made.data);
        for (int64_t i = 0; i < size.height * length; ++i) {
          const double a = dx.ptr<double>()[i], b = dy.ptr<double>()[i];
          ASSERT_EQ(made.data[i], std::min(std::nearbyint(std::sqrt(a * a + b * b) / divisor), 255.0))
              << image.size() << " x " << channels << " at " << i << ", by " << divisor;
        }
      }
    }
}

// Gradients along one axis, whose lengths are whole, and halves between two results among them.
TEST_F(Bytes, HalvesOfMagnitudesAreRoundedToEven) {
  for (int level = 0; level < 256; ++level) {
    cv::Mat image(3, 40, CV_8U), made(3, 40, CV_8U);
    for (int i = 0; i < 120; ++i) image.data[i] = static_cast<uint8_t>(i % 40 < 20 ? 0 : level);
    for (const auto& [side, centre, divisor] : std::initializer_list<std::array<int, 3>>{
             {3, 10, 32}, {1, 1, 6}, {1, 2, 8}, {0, 1, 2}, {0, 1, 64}, {16, 0, 64}}) {
      magnitude_of_bytes(image.data, 1, 3, 40, 1, side, centre, divisor, made.data);
      const double expected = std::min(std::nearbyint(double(level * (2 * side + centre)) / divisor), 255.0);
      EXPECT_EQ(made.data[40 + 19], expected) << level << " by " << divisor;
      EXPECT_EQ(made.data[40 + 20], expected) << level << " by " << divisor;
    }
  }
}

KERNEL_CALL_BENCHMARK(derivatives_of_bytes_sobel, [] {
  return [frame = Frame(), out = std::vector<int16_t>(2 * 1080 * 1920 * 3)]() mutable {
    derivatives_of_bytes(frame.x.data(), 3, 1080, 1920, 1, 2, out.data());
  };
});

KERNEL_CALL_BENCHMARK(derivatives_of_bytes_scharr, [] {
  return [frame = Frame(), out = std::vector<int16_t>(2 * 1080 * 1920 * 3)]() mutable {
    derivatives_of_bytes(frame.x.data(), 3, 1080, 1920, 3, 10, out.data());
  };
});

KERNEL_CALL_BENCHMARK(magnitude_of_bytes_sobel_3, [] {
  return [frame = Frame()]() mutable {
    magnitude_of_bytes(frame.x.data(), 1, 1080, 1920 * 3, 3, 1, 2, 8, frame.out.data());
  };
});

KERNEL_CALL_BENCHMARK(magnitude_of_bytes_scharr_3, [] {
  return [frame = Frame()]() mutable {
    magnitude_of_bytes(frame.x.data(), 1, 1080, 1920 * 3, 3, 3, 10, 32, frame.out.data());
  };
});

}  // namespace
