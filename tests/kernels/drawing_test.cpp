// The kernels that draw, against OpenCV.
#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "benchmarks.h"
#include "fixture.h"
#include "kernels.h"

using namespace chiasm::kernels;

namespace {

const Images kImages[] = {{1, 1, 1, 1}, {2, 1, 1, 9}, {1, 2, 9, 1}, {2, 3, 31, 43}};

template <class T>
class Drawing : public KernelsTest<T> {
 protected:
  Drawing() : KernelsTest<T>(41) {}

  std::vector<int64_t> whole(int64_t n, int64_t low, int64_t high) {
    std::uniform_int_distribution<int64_t> draw(low, high);
    std::vector<int64_t> values(static_cast<size_t>(n));
    for (int64_t& v : values) v = draw(this->engine_);
    return values;
  }
};

using Types = ::testing::Types<uint8_t, int16_t, uint16_t, float, double>;
TYPED_TEST_SUITE(Drawing, Types);

TYPED_TEST(Drawing, RectanglesMatchOpenCv) {
  using T = TypeParam;
  constexpr int64_t count = 7;
  for (const Images& v : kImages)
    for (const bool fill : {true, false})
      for (const int64_t line : {1, 2, 5}) {
        const int64_t size = v.height * v.width, before = line / 2, after = line - 1 - before;
        const auto image = this->random(v.count * v.channels * size, 0, 200),
                   colors = this->random(v.count * v.channels * count, 0, 200);
        auto corners = this->whole(v.count * count * 4, -9, 50);
        corners[0] = INT64_MIN;  // from far left of any image to far right
        corners[1] = -3;
        corners[2] = INT64_MAX;
        std::vector<T> out(image.size());
        draw_rectangles(image.data(), v, corners.data(), count, colors.data(), before, after, fill,
                        out.data());
        for (int64_t plane = 0; plane < v.count * v.channels; ++plane) {
          cv::Mat expected(int(v.height), int(v.width), cv::DataType<T>::type);
          std::copy_n(image.data() + plane * size, size, expected.ptr<T>());
          for (int64_t i = 0; i < count; ++i) {
            int c[4];
            for (int k = 0; k < 4; ++k)
              c[k] = int(
                  std::clamp<int64_t>(corners[size_t((plane / v.channels * count + i) * 4 + k)], -999, 999));
            if (c[2] < c[0] || c[3] < c[1]) continue;
            const auto color = static_cast<double>(colors[size_t(plane * count + i)]);
            const auto grown = [&](int64_t to_top_left, int64_t to_bottom_right) {
              return cv::Rect(cv::Point(c[0] - int(to_top_left), c[1] - int(to_top_left)),
                              cv::Point(c[2] + int(to_bottom_right) + 1, c[3] + int(to_bottom_right) + 1));
            };
            if (fill || line == 1) {
              cv::rectangle(expected, grown(0, 0), cv::Scalar(color), fill ? int(cv::FILLED) : 1);
              continue;
            }
            // OpenCV's wide lines have round corners: the reference is rectangles minus inner ones
            cv::Mat covered = cv::Mat::zeros(expected.size(), CV_8U);
            cv::rectangle(covered, grown(before, after), cv::Scalar(255), cv::FILLED);
            const cv::Rect inner = grown(-after - 1, -before - 1);
            if (c[2] - before - 1 > c[0] + after && c[3] - before - 1 > c[1] + after)
              cv::rectangle(covered, inner, cv::Scalar(0), cv::FILLED);
            expected.setTo(color, covered);
          }
          const cv::Mat actual(int(v.height), int(v.width), cv::DataType<T>::type, out.data() + plane * size);
          ASSERT_EQ(cv::norm(actual, expected, cv::NORM_INF), 0)
              << v.height << "x" << v.width << ", line " << line << ", fill " << fill;
        }
      }
}

KERNEL_CALL_BENCHMARK(draw_rectangles, [] {
  std::vector<int64_t> corners;
  for (int64_t i = 0; i < 100; ++i)
    for (const int64_t c : {i * 17, i * 9, i * 17 + 200, i * 9 + 150}) corners.push_back(c);
  return [corners, image = kernel_benchmarks::random(3 * 1080 * 1920), colors = std::vector<float>(300, 1.0f),
          out = std::vector<float>(3 * 1080 * 1920)]() mutable {
    draw_rectangles(image.data(), {1, 3, 1080, 1920}, corners.data(), 100, colors.data(), 0, 0, false,
                    out.data());
  };
});

TYPED_TEST(Drawing, SpansMatchOpenCvsRows) {
  using T = TypeParam;
  for (const Images& v : kImages)
    for (const int64_t spans : {0, 1, 2}) {
      const int64_t size = v.height * v.width;
      const auto image = this->random(v.count * v.channels * size, 0, 200),
                 colors = this->random(v.count * v.channels, 0, 200);
      auto first = this->whole(v.count * spans * v.height, -5, 50),
           end = this->whole(v.count * spans * v.height, -5, 50);
      if (spans > 0) first[0] = INT64_MIN, end[0] = INT64_MAX;
      std::vector<T> out(image.size());
      fill_spans(image.data(), v, first.data(), spans, end.data(), colors.data(), out.data());
      for (int64_t plane = 0; plane < v.count * v.channels; ++plane) {
        cv::Mat expected(int(v.height), int(v.width), cv::DataType<T>::type);
        std::copy_n(image.data() + plane * size, size, expected.ptr<T>());
        for (int64_t k = 0; k < spans; ++k)
          for (int64_t y = 0; y < v.height; ++y) {
            const size_t at = size_t((plane / v.channels * spans + k) * v.height + y);
            const int from = int(std::clamp<int64_t>(first[at], 0, v.width)),
                      to = int(std::clamp<int64_t>(end[at], 0, v.width));
            if (from < to)
              expected(cv::Rect(from, int(y), to - from, 1)).setTo(double(colors[size_t(plane)]));
          }
        const cv::Mat actual(int(v.height), int(v.width), cv::DataType<T>::type, out.data() + plane * size);
        ASSERT_EQ(cv::norm(actual, expected, cv::NORM_INF), 0) << v.height << "x" << v.width;
      }
    }
}

KERNEL_CALL_BENCHMARK(fill_spans, [] {
  return [image = kernel_benchmarks::random(3 * 1080 * 1920), colors = std::vector<float>(3, 1.0f),
          first = std::vector<int64_t>(1080, 300), end = std::vector<int64_t>(1080, 1500),
          out = std::vector<float>(3 * 1080 * 1920)]() mutable {
    fill_spans(image.data(), {1, 3, 1080, 1920}, first.data(), 1, end.data(), colors.data(), out.data());
  };
});

}  // namespace
