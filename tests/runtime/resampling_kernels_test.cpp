// The kernels that read images between pixels, against the definition in plain loops of doubles and against OpenCV's resize.
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "kernels_fixture.h"
#include "shim/kernels/kernels.h"

using namespace chiasm::kernels;

namespace {

template <class T>
class Resampling : public KernelsTest<T> {
 protected:
  Resampling() : KernelsTest<T>(11) {}
};

using Types = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Resampling, Types);

// A single pixel, a row, a column, less than a vector, and more than a block.
const Images kImages[] = {{1, 1, 1, 1}, {2, 1, 1, 5}, {1, 2, 7, 1}, {2, 3, 3, 2}, {2, 3, 40, 150}};
constexpr Padding kPaddings[] = {Padding::kZeros, Padding::kBorder, Padding::kReflection};

double placed(double x, int64_t size, Padding padding, bool corners) {
  const double low = corners ? 0 : -0.5, high = corners ? double(size - 1) : double(size) - 0.5;
  if (padding == Padding::kBorder) return std::clamp(x, 0.0, double(size - 1));
  if (padding == Padding::kZeros) return x;
  while ((x < low || x > high) && high > low) x = x < low ? 2 * low - x : 2 * high - x;
  return std::clamp(x, 0.0, double(size - 1));
}

template <class T>
double sampled(const T* plane, int64_t height, int64_t width, double x, double y, Interpolation mode) {
  const auto pixel = [&](double row, double column) {
    return row < 0 || column < 0 || row > double(height - 1) || column > double(width - 1) ? 0.0 : double(plane[int64_t(row) * width + int64_t(column)]);
  };
  if (mode == Interpolation::kNearest) return pixel(std::nearbyint(y), std::nearbyint(x));
  const double r = std::floor(y), c = std::floor(x), fy = y - r, fx = x - c;
  return (pixel(r, c) * (1 - fx) + pixel(r, c + 1) * fx) * (1 - fy) + (pixel(r + 1, c) * (1 - fx) + pixel(r + 1, c + 1) * fx) * fy;
}

TYPED_TEST(Resampling, SamplesAreTheirDefinition) {
  using T = TypeParam;
  constexpr int64_t height = 35, width = 133;
  for (const Images& images : kImages)
    for (const Padding padding : kPaddings)
      for (const bool corners : {true, false})
        for (const Interpolation mode : {Interpolation::kBilinear, Interpolation::kNearest}) {
          const int64_t plane = images.height * images.width, points = images.count * height * width;
          const auto image = this->random(images.count * images.channels * plane, 0, 1);
          // In steps of 1/4 plus 1/16, so that float and double agree on what is nearest.
          auto x = this->random(points, -2.5 * double(images.width), 3.5 * double(images.width)), y = this->random(points, -2.5 * double(images.height), 3.5 * double(images.height));
          for (auto* positions : {&x, &y})
            for (T& v : *positions) v = std::floor(v * 4) / 4 + T(0.0625);
          std::vector<T> out(static_cast<size_t>(images.count * images.channels * height * width));
          sample(image.data(), images, x.data(), y.data(), height, width, mode, padding, corners, out.data());
          for (int64_t i = 0; i < int64_t(out.size()); ++i) {
            const int64_t p = i / (height * width), at = p / images.channels * height * width + i % (height * width);
            const double u = placed(double(x[size_t(at)]), images.width, padding, corners), v = placed(double(y[size_t(at)]), images.height, padding, corners);
            ASSERT_NEAR(double(out[size_t(i)]), sampled(image.data() + p * plane, images.height, images.width, u, v, mode), 1e-5)
                << images.height << "x" << images.width << " at " << x[size_t(at)] << ", " << y[size_t(at)] << ", padding " << int(padding);
          }
        }
}

TYPED_TEST(Resampling, PositionsThatAreNoNumbersOrHugeReadNothing) {
  using T = TypeParam;
  const Images images{1, 1, 9, 9};
  const std::vector<T> image(81, T(1));
  constexpr T kInfinity = std::numeric_limits<T>::infinity();
  const std::vector<T> x{std::numeric_limits<T>::quiet_NaN(), kInfinity, -kInfinity, T(1e30), T(-1e30), T(4), T(4), T(4), T(4)}, y(9, T(4));
  std::vector<T> out(9);
  for (const Interpolation mode : {Interpolation::kBilinear, Interpolation::kNearest}) {
    sample(image.data(), images, x.data(), y.data(), 1, 9, mode, Padding::kZeros, true, out.data());
    EXPECT_EQ(out, (std::vector<T>{0, 0, 0, 0, 0, 1, 1, 1, 1}));
  }
}

TYPED_TEST(Resampling, ProjectiveSamplesAreThoseAtTheMatrixesPositions) {
  using T = TypeParam;
  constexpr int64_t height = 37, width = 141;
  for (const Images& images : kImages) {
    const auto image = this->random(images.count * images.channels * images.height * images.width, 0, 1), noise = this->random(9 * images.count, -0.05, 0.05);
    std::vector<T> matrices(noise), x(static_cast<size_t>(images.count * height * width)), y(x);
    for (int64_t b = 0; b < images.count; ++b) {
      T* const m = matrices.data() + 9 * b;
      m[0] += T(0.9), m[4] += T(1.1), m[8] += T(1), m[6] *= T(0.02), m[7] *= T(0.02);
      for (int64_t i = 0; i < height * width; ++i) {
        const auto u = static_cast<T>(i % width), v = static_cast<T>(i / width);
        x[size_t(b * height * width + i)] = (m[0] * u + m[1] * v + m[2]) / (m[6] * u + m[7] * v + m[8]);
        y[size_t(b * height * width + i)] = (m[3] * u + m[4] * v + m[5]) / (m[6] * u + m[7] * v + m[8]);
      }
    }
    std::vector<T> out(static_cast<size_t>(images.count * images.channels * height * width)), expected(out);
    sample_projective(image.data(), images, matrices.data(), height, width, Interpolation::kBilinear, Padding::kBorder, true, out.data());
    sample(image.data(), images, x.data(), y.data(), height, width, Interpolation::kBilinear, Padding::kBorder, true, expected.data());
    for (size_t i = 0; i < out.size(); ++i) ASSERT_NEAR(out[i], expected[i], 1e-5);
  }
}

// The pixels and weights of OpenCV's interpolation: Keys' cubic with a = -0.75 for four taps, linear for two.
template <class T>
struct Table {
  std::vector<int32_t> index;
  std::vector<T> weight;

  Table(int64_t in, int64_t out, int64_t taps) {
    for (int64_t i = 0; i < out; ++i) {
      const double x = (double(i) + 0.5) * double(in) / double(out) - 0.5, whole = std::floor(x);
      for (int64_t k = 0; k < taps; ++k) {
        const double pixel = whole + double(k - taps / 2 + 1), d = std::abs(x - pixel), a = -0.75;
        const double cubic = d <= 1 ? ((a + 2) * d - (a + 3)) * d * d + 1 : d < 2 ? ((a * d - 5 * a) * d + 8 * a) * d - 4 * a : 0;
        index.push_back(int32_t(std::clamp(pixel, 0.0, double(in - 1))));
        weight.push_back(T(taps == 2 ? 1 - d : cubic));
      }
    }
  }
};

TYPED_TEST(Resampling, ResamplingByTablesIsOpenCvsResize) {
  using T = TypeParam;
  for (const Planes& p : {Planes{1, 1, 1}, Planes{2, 3, 5}, Planes{1, 40, 71}, Planes{1, 40, 142}, Planes{2, 7, 1}})
    for (const auto& [height, width] : {std::pair<int64_t, int64_t>{1, 1}, {2, 9}, {19, 33}, {20, 71}, {19, 72}, {80, 142}, {5, 300}, {90, 4}})
      for (const int64_t taps : {2, 4}) {
        const auto x = this->random(p.count * p.height * p.width, 0, 1);
        const Table<T> down(p.height, height, taps), across(p.width, width, taps);
        std::vector<T> out(static_cast<size_t>(p.count * height * width));
        resample(x.data(), p, down.index.data(), down.weight.data(), taps, height, across.index.data(), across.weight.data(), taps, width, out.data());
        for (int64_t i = 0; i < p.count; ++i) {
          const cv::Mat plane(int(p.height), int(p.width), cv::DataType<T>::type, const_cast<T*>(x.data() + i * p.height * p.width));
          const cv::Mat actual(int(height), int(width), cv::DataType<T>::type, out.data() + i * height * width);
          cv::Mat expected;
          cv::resize(plane, expected, actual.size(), 0, 0, taps == 2 ? cv::INTER_LINEAR : cv::INTER_CUBIC);
          EXPECT_LE(cv::norm(expected, actual, cv::NORM_INF), 2e-5) << p.height << "x" << p.width << " to " << height << "x" << width << ", " << taps << " taps";
        }
      }
}

// Six symmetric taps: the mean of two by two pixels that are blurred by (1, 4, 6, 4, 1) / 16.
TYPED_TEST(Resampling, BlurringAndHalvingIsOpenCvsInOneStep) {
  using T = TypeParam;
  const T binomial[] = {1, 4, 6, 4, 1};
  const auto table = [&](int64_t size, std::vector<int32_t>& index, std::vector<T>& weight) {
    for (int i = 0; i < size; ++i)  // both pixels of each position, one after the other
      for (int k = 0; k < 5; ++k) {
        index.push_back(cv::borderInterpolate(i + k - 2, int(size), cv::BORDER_REFLECT_101));
        weight.push_back(binomial[k] / 32);
      }
  };
  for (const Planes& p : {Planes{2, 4, 6}, Planes{1, 16, 34}, Planes{3, 70, 150}}) {
    const auto x = this->random(p.count * p.height * p.width, 0, 1);
    std::vector<int32_t> rows, columns;
    std::vector<T> down, across;
    table(p.height, rows, down);
    table(p.width, columns, across);
    const int64_t height = p.height / 2, width = p.width / 2;
    std::vector<T> out(static_cast<size_t>(p.count * height * width));
    resample(x.data(), p, rows.data(), down.data(), 10, height, columns.data(), across.data(), 10, width, out.data());
    for (int64_t i = 0; i < p.count; ++i) {
      const cv::Mat plane(int(p.height), int(p.width), cv::DataType<T>::type, const_cast<T*>(x.data() + i * p.height * p.width));
      const cv::Mat actual(int(height), int(width), cv::DataType<T>::type, out.data() + i * height * width), taps(1, 5, cv::DataType<T>::type, const_cast<T*>(binomial));
      cv::Mat expected;
      cv::sepFilter2D(plane, expected, -1, taps / 16, taps / 16, {-1, -1}, 0, cv::BORDER_REFLECT_101);
      cv::resize(expected, expected, actual.size(), 0, 0, cv::INTER_AREA);
      EXPECT_LE(cv::norm(expected, actual, cv::NORM_INF), 1e-6) << p.height << "x" << p.width;
    }
  }
}

}  // namespace
