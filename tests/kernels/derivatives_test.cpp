// First derivatives of bytes: against OpenCV.
#include "bytes.h"

namespace {

using namespace chiasm::kernels;

TEST_F(Bytes, DerivativesMatchOpenCv) {
  for (const Size& size : kSizes) {
    const cv::Mat image = frame(size.height, size.width, 1);
    std::vector<int16_t> out(2 * image.total());
    sobel_derivatives(image.data, 1, size.height, size.width, out.data());
    for (const int down : {0, 1}) {
      cv::Mat expected;
      cv::Sobel(image, expected, CV_16S, 1 - down, down, 3, 1, 0, cv::BORDER_REPLICATE);
      const cv::Mat made(image.size(), CV_16S, out.data() + static_cast<size_t>(down) * image.total());
      EXPECT_EQ(cv::norm(made, expected, cv::NORM_INF), 0) << image.size() << " " << down;
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
      cv::Sobel(image, dx, CV_16S, 1, 0, 3, 1, 0, cv::BORDER_REPLICATE);
      cv::Sobel(image, dy, CV_16S, 0, 1, 3, 1, 0, cv::BORDER_REPLICATE);
      const int64_t length = int64_t{size.width} * channels;
      for (const double scale : {0.125, 1.0}) {
        sobel_bytes(image.data, 1, size.height, length, channels, scale, made.data);
        for (int64_t i = 0; i < size.height * length; ++i) {
          const double a = dx.ptr<int16_t>()[i], b = dy.ptr<int16_t>()[i];
          ASSERT_EQ(made.data[i], std::min(std::nearbyint(std::sqrt(a * a + b * b) * scale), 255.0))
              << image.size() << " x " << channels << " at " << i << " times " << scale;
        }
      }
    }
}

KERNEL_CALL_BENCHMARK(sobel_derivatives, [] {
  return [frame = Frame(), out = std::vector<int16_t>(2 * 1080 * 1920 * 3)]() mutable {
    sobel_derivatives(frame.x.data(), 3, 1080, 1920, out.data());
  };
});

KERNEL_CALL_BENCHMARK(sobel_bytes_3, [] {
  return [frame = Frame()]() mutable {
    sobel_bytes(frame.x.data(), 1, 1080, 1920 * 3, 3, 0.125, frame.out.data());
  };
});

}  // namespace
