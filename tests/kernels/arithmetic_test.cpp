// Arithmetic on pixels, value by value, against OpenCV or the definition.
#include <algorithm>
#include <cmath>
#include <limits>

#include "bytes.h"

using namespace chiasm::kernels;

namespace {

TEST_F(Bytes, DifferencesMatchOpenCv) {
  for (const Size& size : kSizes)
    for (const int type : {CV_8UC3, CV_16UC3, CV_16SC3, CV_32FC3, CV_64FC3}) {
      cv::Mat x(size.height, size.width, type), y(x.size(), type), out(x.size(), type), expected;
      cv::RNG rng(5);
      const double low = CV_MAT_DEPTH(type) == CV_16S ? -32768 : 0,
                   high = CV_MAT_DEPTH(type) == CV_8U ? 256 : 32768;
      rng.fill(x, cv::RNG::UNIFORM, low, high);
      rng.fill(y, cv::RNG::UNIFORM, low, high);
      cv::subtract(x, y, expected);
      const auto values = static_cast<int64_t>(x.total() * 3);
      switch (CV_MAT_DEPTH(type)) {
        case CV_8U: subtract_pixels(x.data, 1, values, y.data, out.data); break;
        case CV_16U:
          subtract_pixels(x.ptr<uint16_t>(), 1, values, y.ptr<uint16_t>(), out.ptr<uint16_t>());
          break;
        case CV_16S:
          subtract_pixels(x.ptr<int16_t>(), 1, values, y.ptr<int16_t>(), out.ptr<int16_t>());
          break;
        case CV_32F: subtract_pixels(x.ptr<float>(), 1, values, y.ptr<float>(), out.ptr<float>()); break;
        default: subtract_pixels(x.ptr<double>(), 1, values, y.ptr<double>(), out.ptr<double>());
      }
      EXPECT_EQ(cv::norm(out, expected, cv::NORM_INF), 0)
          << size.height << " x " << size.width << ", " << type;
    }
}

TEST_F(Bytes, WeightedSumsMatchTheirDefinition) {
  const float infinity = std::numeric_limits<float>::infinity();
  const std::vector<std::vector<float>> sets = {{0.3f, 0.6f, 5.5f}, {-1, 2, 0},          {0.5f, 0, 0},
                                                {1e30f, 1, 0},      {NAN, 1, 2},         {1, 1, infinity},
                                                {1, 1, -infinity},  {0.25f, 0.25f, 0.5f}};
  for (const Size& size : kSizes)
    for (const auto& weights : sets) {
      const cv::Mat x = frame(size.height, size.width, 3), y = frame(size.height, size.width, 3);
      cv::Mat out(x.size(), x.type());
      const auto values = static_cast<int64_t>(x.total() * 3);
      add_weighted(x.data, 1, values, y.data, weights.data(), 1, out.data);
      for (int64_t i = 0; i < values; ++i) {
        const float first = float(x.data[i]) * weights[0], second = float(y.data[i]) * weights[1];
        const float both = first + second;
        const float sum = both + weights[2];
        const float expected = std::isnan(sum) ? 0 : std::nearbyint(std::clamp(sum, 0.0f, 255.0f));
        ASSERT_EQ(out.data[i], expected) << weights[0] << " " << weights[1] << " " << weights[2];
      }
    }
}

TEST_F(Bytes, RangesMatchOpenCv) {
  for (const Size& size : kSizes)
    for (const int channels : {1, 2, 3, 4})
      for (const int least : {-3, 0, 60, 256}) {
        const cv::Mat image = frame(size.height, size.width, channels);
        const std::vector<int32_t> low(4, least), high = {200, 255, 180, 300};
        cv::Mat mask(image.size(), CV_8U), expected, kept(image.size(), image.type()), wanted;
        cv::inRange(image, cv::Scalar(least, least, least, least), cv::Scalar(200, 255, 180, 300), expected);
        image.copyTo(wanted, expected);
        const auto values = static_cast<int64_t>(image.total() * image.channels());
        in_range(image.data, 1, values, low.data(), 1, channels, high.data(), true, mask.data);
        EXPECT_EQ(cv::norm(mask, expected, cv::NORM_INF), 0)
            << image.size() << " x " << channels << " from " << least;
        masked_pixels(image.data, 1, values, mask.data, values / channels, true, kept.data);
        EXPECT_EQ(cv::norm(kept, wanted, cv::NORM_INF), 0) << image.size() << " x " << channels;
        std::vector<uint8_t> planes(static_cast<size_t>(values)), made(planes.size()), back(planes.size());
        split_pixels(image.data, 1, values, channels, planes.data());
        in_range(planes.data(), 1, values, low.data(), 1, channels, high.data(), false, mask.data);
        EXPECT_EQ(cv::norm(mask, expected, cv::NORM_INF), 0)
            << image.size() << " x " << channels << " planes";
        masked_pixels(planes.data(), 1, values, mask.data, values / channels, false, made.data());
        join_pixels(made.data(), 1, values, channels, back.data());
        EXPECT_TRUE(std::equal(back.begin(), back.end(), wanted.data)) << image.size() << " x " << channels;
      }
}

constexpr int64_t kValues = 1080 * 1920 * 3;
TEST_F(Bytes, ScaledBytesAreProductsAndSums) {
  for (const int channels : {1, 2, 3, 4, 5, 7})
    for (const Size& size : {Size{1, 1}, Size{3, 11}, Size{2, 4096 + 37}}) {
      const cv::Mat image = frame(2 * size.height, size.width, channels);
      const int64_t pixels = size.height * size.width, values = pixels * channels;
      std::vector<uint8_t> planes(static_cast<size_t>(2 * values));
      split_pixels(image.data, 2, values, channels, planes.data());
      const std::vector<int32_t> order = {channels - 1, 0, channels, -1};
      const std::vector<float> by = {0.25f, -3, 1.0f / 255, 0.1f, 5, 7, 1, -2};
      std::vector<float> out(static_cast<size_t>(2 * 4 * pixels)), again(out.size());
      scaled_bytes(image.data, 2, values, order.data(), 4, by.data(), channels, true, out.data());
      scaled_bytes(planes.data(), 2, values, order.data(), 4, by.data(), channels, false, again.data());
      EXPECT_EQ(out, again);
      for (int64_t i = 0; i < 2; ++i)
        for (int64_t k = 0; k < pixels; ++k) {
          const uint8_t* const p = image.data + i * values + k * channels;
          const auto made = [&](int64_t plane) { return out[size_t((4 * i + plane) * pixels + k)]; };
          ASSERT_EQ(made(0), 0.25f * float(p[channels - 1]) - 3);
          ASSERT_NEAR(made(1), float(p[0]) / 255 + 0.1f, 2e-7);
          ASSERT_EQ(made(2), 7);
          ASSERT_EQ(made(3), -2);
        }
    }
}

KERNEL_CALL_BENCHMARK(scaled_bytes, [] {
  return [frame = Frame(), out = std::vector<float>(1080 * 1920 * 3)]() mutable {
    static const int32_t order[] = {2, 1, 0};
    static const float by[] = {0.017f, -2, 0.017f, -2, 0.017f, -2};
    scaled_bytes(frame.x.data(), 1, 1080 * 1920 * 3, order, 3, by, 3, true, out.data());
  };
});
KERNEL_CALL_BENCHMARK(subtract_pixels, [] {
  return [frame = Frame(), other = Frame()]() mutable {
    subtract_pixels(frame.x.data(), 1, kValues, other.x.data(), frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(add_weighted, [] {
  return [frame = Frame(), other = Frame(), weights = std::vector<float>{0.3f, 0.6f, 5.0f}]() mutable {
    add_weighted(frame.x.data(), 1, kValues, other.x.data(), weights.data(), 1, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(in_range_3, [] {
  static const std::vector<int32_t> low = {20, 30, 40}, high = {200, 190, 180};
  return [frame = Frame()]() mutable {
    in_range(frame.x.data(), 1, kValues, low.data(), 1, 3, high.data(), true, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(masked_pixels_3, [] {
  return [frame = Frame(), mask = Frame()]() mutable {
    masked_pixels(frame.x.data(), 1, kValues, mask.x.data(), kValues / 3, true, frame.out.data());
  };
});
}  // namespace
