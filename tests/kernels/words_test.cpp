// Kernels of 16-bit pixels, against their definition in integers, and OpenCV.
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <random>

#include "benchmarks.h"
#include "bytes.h"
#include "kernels.h"

using namespace chiasm::kernels;

namespace {

template <class S>
class Words : public ::testing::Test {
 protected:
  void SetUp() override { use_threads(3); }

  static constexpr int kDepth = std::is_signed_v<S> ? CV_16S : CV_16U;

  cv::Mat frame(int height, int width, int channels) {
    cv::Mat image(height, width, CV_MAKETYPE(kDepth, channels));
    for (int y = 0; y < height; ++y)
      for (int i = 0; i < width * channels; ++i) image.ptr<S>(y)[i] = static_cast<S>(engine_());
    return image;
  }

  int64_t draw(int64_t low, int64_t high) {
    return std::uniform_int_distribution<int64_t>(low, high)(engine_);
  }

  static int64_t saturated(int64_t value) {
    return std::clamp<int64_t>(value, std::numeric_limits<S>::min(), std::numeric_limits<S>::max());
  }

  std::mt19937 engine_{5};
};
using Types = ::testing::Types<int16_t, uint16_t>;
TYPED_TEST_SUITE(Words, Types);

int64_t floor_of(int64_t numerator, int64_t denominator) {
  const int64_t quotient = numerator / denominator;
  return quotient - (numerator % denominator < 0 ? 1 : 0);
}

// With weights that overshoot, that are 0, and for pixels that do not exist.
TYPED_TEST(Words, ResamplingMatchesItsDefinition) {
  using S = TypeParam;
  for (const Size& size : kSizes)
    for (const Size& to : {Size{1, 1}, Size{7, 5}, Size{20, 61}})
      for (const int channels : {1, 2, 3, 4, 5})
        for (const int64_t total : {int64_t{1} << 36, int64_t{3'000'017} * 20'011})
          for (const int64_t taps : {1, 2, 5}) {
            const cv::Mat image = this->frame(2 * size.height, size.width, channels);
            const auto numbers = [&](int64_t count, int64_t low, int64_t high) {
              std::vector<int64_t> made(static_cast<size_t>(count * taps));
              for (int64_t& v : made) v = this->draw(0, 4) == 0 ? 0 : this->draw(low, high);
              return made;
            };
            const std::vector<int64_t> rows = numbers(to.height, -2, size.height + 1),
                                       columns = numbers(to.width, -2, size.width + 1),
                                       down = numbers(to.height, -60000, 300000),
                                       across = numbers(to.width, -60000, 300000);
            std::vector<S> out(static_cast<size_t>(2 * to.height * to.width * channels));
            resample_words(reinterpret_cast<const S*>(image.data), 2, size.height, size.width * channels,
                           rows.data(), to.height, taps, down.data(), columns.data(), to.width, taps,
                           across.data(), &total, channels, out.data());
            size_t at = 0;
            for (int i = 0; i < 2; ++i)
              for (int y = 0; y < to.height; ++y)
                for (int x = 0; x < to.width; ++x)
                  for (int c = 0; c < channels; ++c) {
                    int64_t sum = 0;
                    for (int64_t k = 0; k < taps; ++k)
                      for (int64_t j = 0; j < taps; ++j) {
                        const auto row = static_cast<size_t>(y * taps + k),
                                   column = static_cast<size_t>(x * taps + j);
                        const auto v = static_cast<int>(std::clamp<int64_t>(rows[row], 0, size.height - 1)),
                                   u = static_cast<int>(
                                       std::clamp<int64_t>(columns[column], 0, size.width - 1));
                        sum +=
                            down[row] * across[column] * image.ptr<S>(i * size.height + v)[u * channels + c];
                      }
                    ASSERT_EQ(out[at++], this->saturated(floor_of(2 * sum + total, 2 * total)))
                        << image.size() << " to " << to.height << " x " << channels;
                  }
          }
}

constexpr int64_t kSteps = 65536;

// A position in an image of `size` pixels, in 1/65536, moved as the padding says; -1 reads nothing.
int64_t step_of(double at, int64_t size, int64_t steps, Padding padding, bool align_corners) {
  if (std::isnan(at)) return -steps;
  const double limited = std::clamp(at, -16777216.0, 16777216.0);
  auto step = static_cast<int64_t>(std::nearbyint(limited * static_cast<double>(steps)));
  const int64_t last = steps * (size - 1);
  if (padding == Padding::kBorder) return std::clamp<int64_t>(step, 0, last);
  if (padding == Padding::kReflection) {
    if (size == 1) return 0;
    const int64_t edge = align_corners ? 0 : steps / 2;  // the mirror is that far outside
    if (steps == 1 && !align_corners) {                  // whole pixels: the mirror is half a step outside
      while (step < 0 || step > last) step = step < 0 ? -1 - step : 2 * last + 1 - step;
      return step;
    }
    while (step < -edge || step > last + edge)
      step = step < -edge ? -2 * edge - step : 2 * (last + edge) - step;
    return std::clamp<int64_t>(step, 0, last);
  }
  return step;
}

template <class S>
int64_t read(const cv::Mat& image, int c, int64_t x, int64_t y, bool nearest, S fill) {
  const auto pixel = [&](int64_t v, int64_t u) -> int64_t {
    if (v < 0 || v >= image.rows || u < 0 || u >= image.cols) return fill;
    return image.ptr<S>(static_cast<int>(v))[u * image.channels() + c];
  };
  if (nearest) return pixel(y, x);
  const int64_t column = floor_of(x, kSteps), row = floor_of(y, kSteps), right = x - column * kSteps,
                below = y - row * kSteps;
  const auto across = [&](int64_t v) {
    return pixel(v, column) * (kSteps - right) + pixel(v, column + 1) * right;
  };
  const int64_t sum = across(row) * (kSteps - below) + across(row + 1) * below;
  return floor_of(sum + kSteps * kSteps / 2, kSteps * kSteps);
}

constexpr Interpolation kModes[] = {Interpolation::kNearest, Interpolation::kBilinear};
constexpr Padding kPaddings[] = {Padding::kZeros, Padding::kBorder, Padding::kReflection};

TYPED_TEST(Words, RemappedPixelsMatchTheDefinition) {
  using S = TypeParam;
  for (const Size& size : kSizes)
    for (const int channels : {1, 2, 3, 4})
      for (const Interpolation mode : kModes)
        for (const Padding padding : kPaddings)
          for (const bool align_corners : {true, false}) {
            const bool nearest = mode == Interpolation::kNearest;
            const cv::Mat image = this->frame(size.height, size.width, channels);
            cv::Mat x(9, 300, CV_64F), y(9, 300, CV_64F), out(9, 300, image.type());
            cv::RNG rng(3);
            rng.fill(x, cv::RNG::UNIFORM, -0.1 * size.width - 2, 1.1 * size.width + 2);
            rng.fill(y, cv::RNG::UNIFORM, -0.1 * size.height - 2, 1.1 * size.height + 2);
            std::vector<S> fill;
            for (int c = 0; c < channels; ++c) fill.push_back(static_cast<S>(this->engine_()));
            x.at<double>(0, 0) = x.at<double>(1, 7) = y.at<double>(2, 3) = std::nan("");
            x.at<double>(3, 3) = 1e30;
            y.at<double>(3, 4) = -INFINITY;
            x.at<double>(3, 5) = size.width - 1;
            remap_words(reinterpret_cast<const S*>(image.data), 1, size.height, size.width * channels,
                        x.ptr<double>(), 1, 9, 300, y.ptr<double>(), channels, mode, padding, align_corners,
                        fill.data(), channels, reinterpret_cast<S*>(out.data));
            for (int v = 0; v < 9; ++v)
              for (int u = 0; u < 300; ++u) {
                if (padding == Padding::kReflection && v == 3) continue;  // too many mirrors for a loop
                const int64_t steps = nearest ? 1 : kSteps;
                const int64_t at_x = step_of(x.at<double>(v, u), size.width, steps, padding, align_corners),
                              at_y = step_of(y.at<double>(v, u), size.height, steps, padding, align_corners);
                for (int c = 0; c < channels; ++c)
                  ASSERT_EQ(out.ptr<S>(v)[u * channels + c],
                            read<S>(image, c, at_x, at_y, nearest, fill[size_t(c)]))
                      << image.size() << " x " << channels << " at " << x.at<double>(v, u) << ", "
                      << y.at<double>(v, u);
              }
          }
}

// Matrices in multiples of 1/1024, so that every CPU has the same positions.
TYPED_TEST(Words, WarpedPixelsMatchTheDefinitionAndAreNearOpenCvs) {
  using S = TypeParam;
  const std::vector<double> affine = {717. / 1024, -300. / 1024, 3, 90. / 1024, 1.25, -5, 0, 0, 1},
                            perspective = {1.5, 0.25, -3, -0.125, 1.5, 2, 0.0625, 0.03125, 1},
                            moved = {1, 0, -3, 0, 1, 5, 0, 0, 1};
  for (const auto& m : {affine, perspective, moved})
    for (const Size& size : kSizes)
      for (const int channels : {1, 2, 3, 4, 5})
        for (const Interpolation mode : kModes) {
          const cv::Mat image = this->frame(size.height, size.width, channels);
          cv::Mat out(40, 280, image.type()), x(40, 280, CV_64F), y(40, 280, CV_64F),
              again(40, 280, image.type());
          for (int v = 0; v < out.rows; ++v)
            for (int u = 0; u < out.cols; ++u) {
              const double depth = m[6] * u + (m[7] * v + m[8]);
              x.at<double>(v, u) = (m[0] * u + (m[1] * v + m[2])) / depth;
              y.at<double>(v, u) = (m[3] * u + (m[4] * v + m[5])) / depth;
            }
          const auto* const pixels = reinterpret_cast<const S*>(image.data);
          const Padding padding = m == moved ? Padding::kZeros : Padding::kBorder;
          const S none = 7;
          warp_words(pixels, 1, size.height, size.width * channels, m.data(), 1, out.rows, out.cols, channels,
                     mode, padding, true, &none, 1, reinterpret_cast<S*>(out.data));
          remap_words(pixels, 1, size.height, size.width * channels, x.ptr<double>(), 1, out.rows, out.cols,
                      y.ptr<double>(), channels, mode, padding, true, &none, 1,
                      reinterpret_cast<S*>(again.data));
          EXPECT_EQ(cv::norm(out, again, cv::NORM_INF), 0) << image.size() << " x " << channels;
          if (mode == Interpolation::kNearest) continue;
          // OpenCV rounds positions to 1/32 pixel: values are up to 1/64 of the range off along each axis.
          cv::Mat expected, x32, y32;
          x.convertTo(x32, CV_32F);
          y.convertTo(y32, CV_32F);
          cv::remap(image, expected, x32, y32, cv::INTER_LINEAR,
                    padding == Padding::kZeros ? cv::BORDER_CONSTANT : cv::BORDER_REPLICATE,
                    cv::Scalar::all(none));
          EXPECT_LE(cv::norm(out, expected, cv::NORM_INF), 2 * 65536 / 64) << image.size();
        }
}

TYPED_TEST(Words, RangesAndThresholdsMatchOpenCv) {
  using S = TypeParam;
  constexpr int kLow = std::numeric_limits<S>::min(), kMiddle = kLow + 32768;
  for (const int channels : {1, 2, 3, 4})
    for (const Size& size : kSizes) {
      cv::Mat image = this->frame(size.height, size.width, channels);
      image.ptr<S>(0)[0] = static_cast<S>(kMiddle);
      const auto values = static_cast<int64_t>(image.total() * image.channels());
      const std::vector<int32_t> low = {kLow - 7, kMiddle - 20000, kMiddle - 9000, kLow},
                                 high = {kMiddle, kMiddle + 40000, kMiddle + 30000, kMiddle + 20000};
      cv::Mat mask(image.size(), CV_8U), expected, kept(image.size(), image.type()), wanted;
      cv::inRange(image, cv::Scalar(low[0], low[1], low[2], low[3]),
                  cv::Scalar(high[0], high[1], high[2], high[3]), expected);
      image.copyTo(wanted, expected);
      const auto* const pixels = reinterpret_cast<const S*>(image.data);
      in_range(pixels, 1, values, low.data(), 1, channels, high.data(), true, mask.data);
      EXPECT_EQ(cv::norm(mask, expected, cv::NORM_INF), 0) << image.size() << " x " << channels;
      masked_pixels(pixels, 1, values, mask.data, values / channels, true, reinterpret_cast<S*>(kept.data));
      EXPECT_EQ(cv::norm(kept, wanted, cv::NORM_INF), 0) << image.size() << " x " << channels;
      std::vector<S> planes(static_cast<size_t>(values)), made(planes.size()), back(planes.size());
      split_pixels(pixels, 1, values, channels, planes.data());
      in_range(planes.data(), 1, values, low.data(), 1, channels, high.data(), false, mask.data);
      EXPECT_EQ(cv::norm(mask, expected, cv::NORM_INF), 0) << image.size() << " x " << channels;
      masked_pixels(planes.data(), 1, values, mask.data, values / channels, false, made.data());
      join_pixels(made.data(), 1, values, channels, back.data());
      EXPECT_TRUE(std::equal(back.begin(), back.end(), wanted.ptr<S>())) << image.size() << " x " << channels;

      struct {
        int type;
        bool keep_above, keep_below;
        int above, below;
      } const kinds[] = {{cv::THRESH_BINARY, false, false, 9000, 0},
                         {cv::THRESH_BINARY_INV, false, false, 0, 9000},
                         {cv::THRESH_TRUNC, false, true, kMiddle, 0},
                         {cv::THRESH_TOZERO, true, false, 0, 0},
                         {cv::THRESH_TOZERO_INV, false, true, 0, 0}};
      for (const auto& kind : kinds) {
        const std::vector<int32_t> limits = {kMiddle, kind.above, kind.below};
        cv::Mat split(image.size(), image.type());
        cv::threshold(image, expected, kMiddle, 9000, kind.type);
        split_at(pixels, 1, values, limits.data(), 1, kind.keep_above, kind.keep_below,
                 reinterpret_cast<S*>(split.data));
        EXPECT_EQ(cv::norm(split, expected, cv::NORM_INF), 0) << image.size() << ", type " << kind.type;
      }
    }
}

TYPED_TEST(Words, LimitsOutsideOfTheRangeSplitNothing) {
  using S = TypeParam;
  constexpr int32_t kLeast = std::numeric_limits<S>::min(), kLargest = std::numeric_limits<S>::max();
  const std::vector<S> x = {kLeast, 0, 9, kLargest};
  for (const int32_t limit : {INT32_MIN, kLeast - 1, kLargest, INT32_MAX}) {
    const std::vector<int32_t> limits = {limit, INT32_MAX, INT32_MIN};
    std::vector<S> out(4);
    split_at(x.data(), 1, 4, limits.data(), 1, false, false, out.data());
    EXPECT_EQ(out, std::vector<S>(4, limit < kLeast ? kLargest : kLeast)) << limit;
  }
}

// A frame of 1080 x 1920 x 3, and an output buffer of the same size.
struct WordFrame {
  std::vector<uint16_t> x = std::vector<uint16_t>(1080 * 1920 * 3), out = std::vector<uint16_t>(x.size());
  WordFrame() {
    std::mt19937 engine(1);
    for (uint16_t& value : x) value = static_cast<uint16_t>(engine());
  }
};

constexpr uint16_t kBlack = 0;

template <int kStep>
auto words_warped() {
  return [frame = WordFrame()]() mutable {
    static const double matrix[] = {0.98, 0.17, -90, -0.17, 0.98, 170, 0, 0, 1};
    warp_words(frame.x.data(), 1, 1080, 1920 * kStep, matrix, 1, 1080, 1920, kStep, Interpolation::kBilinear,
               Padding::kZeros, true, &kBlack, 1, frame.out.data());
  };
}
KERNEL_CALL_BENCHMARK(warp_words_1, [] { return words_warped<1>(); });
KERNEL_CALL_BENCHMARK(warp_words_3, [] { return words_warped<3>(); });
KERNEL_CALL_BENCHMARK(remap_words_3, [] {
  std::vector<double> x, y;
  for (int v = 0; v < 1080; ++v)
    for (int u = 0; u < 1920; ++u) {
      x.push_back(0.98 * u + 0.17 * v - 90);
      y.push_back(-0.17 * u + 0.98 * v + 170);
    }
  return [frame = WordFrame(), x, y]() mutable {
    remap_words(frame.x.data(), 1, 1080, 1920 * 3, x.data(), 1, 1080, 1920, y.data(), 3,
                Interpolation::kBilinear, Padding::kZeros, true, &kBlack, 1, frame.out.data());
  };
});
// To two thirds, bilinear.
template <int kStep>
auto words_resampled() {
  const auto table = [](int64_t count) {
    std::vector<int64_t> index, weight;
    for (int64_t i = 0; i < count; ++i) {
      index.insert(index.end(), {3 * i / 2, 3 * i / 2 + 1});
      weight.insert(weight.end(), {i % 2 == 0 ? 196608 : 65536, i % 2 == 0 ? 65536 : 196608});
    }
    return std::pair(index, weight);
  };
  return [frame = WordFrame(), rows = table(720), columns = table(1280)]() mutable {
    const int64_t total = int64_t{1} << 36;
    resample_words(frame.x.data(), 1, 1080, 1920 * kStep, rows.first.data(), 720, 2, rows.second.data(),
                   columns.first.data(), 1280, 2, columns.second.data(), &total, kStep, frame.out.data());
  };
}
KERNEL_CALL_BENCHMARK(resample_words_1, [] { return words_resampled<1>(); });
KERNEL_CALL_BENCHMARK(resample_words_3, [] { return words_resampled<3>(); });
KERNEL_CALL_BENCHMARK(split_at_3, [] {
  return [frame = WordFrame()]() mutable {
    static const int32_t limits[] = {30000, 65535, 0};
    split_at(frame.x.data(), 1, 1080 * 1920 * 3, limits, 1, false, false, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(in_range_words_3, [] {
  return [frame = WordFrame(), mask = Frame()]() mutable {
    static const int32_t low[] = {9000, 20000, 30000}, high[] = {50000, 60000, 40000};
    in_range(frame.x.data(), 1, 1080 * 1920 * 3, low, 1, 3, high, true, mask.out.data());
  };
});
}  // namespace
