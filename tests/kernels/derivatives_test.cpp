// First derivatives of bytes: against OpenCV.
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

KERNEL_CALL_BENCHMARK(sobel_bytes_3, [] {
  return [frame = Frame()]() mutable {
    sobel_bytes(frame.x.data(), 1, 1080, 1920 * 3, 3, 0.125, frame.out.data());
  };
});

}  // namespace
