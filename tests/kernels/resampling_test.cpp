// The kernels that read images between pixels, against the definition in plain loops of doubles and against
// OpenCV's resize.
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <type_traits>
#include <vector>

#include "artifact/kernels/resize_taps.h"
#include "benchmarks.h"
#include "fixture.h"

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
// What is outside, if a test does not fill it.
template <class T>
constexpr T kNone = 0;

constexpr Padding kPaddings[] = {Padding::kZeros, Padding::kBorder, Padding::kReflection};

double placed(double x, int64_t size, Padding padding, bool corners) {
  const double low = corners ? 0 : -0.5, high = corners ? double(size - 1) : double(size) - 0.5;
  if (padding == Padding::kBorder) return std::clamp(x, 0.0, double(size - 1));
  if (padding == Padding::kZeros) return x;
  while ((x < low || x > high) && high > low) x = x < low ? 2 * low - x : 2 * high - x;
  return std::clamp(x, 0.0, double(size - 1));
}

template <class T>
double sampled(const T* plane, int64_t height, int64_t width, double x, double y, Interpolation mode,
               double outside = 0) {
  const auto pixel = [&](double row, double column) {
    return row < 0 || column < 0 || row > double(height - 1) || column > double(width - 1)
               ? outside
               : double(plane[int64_t(row) * width + int64_t(column)]);
  };
  if (mode == Interpolation::kNearest) return pixel(std::nearbyint(y), std::nearbyint(x));
  const double r = std::floor(y), c = std::floor(x), fy = y - r, fx = x - c;
  return (pixel(r, c) * (1 - fx) + pixel(r, c + 1) * fx) * (1 - fy) +
         (pixel(r + 1, c) * (1 - fx) + pixel(r + 1, c + 1) * fx) * fy;
}

TYPED_TEST(Resampling, RemapMatchesItsDefinition) {
  using T = TypeParam;
  constexpr int64_t height = 35, width = 133;
  for (const Images& images : kImages)
    for (const Padding padding : kPaddings)
      for (const bool corners : {true, false})
        for (const Interpolation mode : {Interpolation::kBilinear, Interpolation::kNearest}) {
          const int64_t plane = images.height * images.width, points = images.count * height * width;
          const auto image = this->random(images.count * images.channels * plane, 0, 1);
          // In steps of 1/4 plus 1/16, so that float and double agree on the nearest pixel.
          auto x = this->random(points, -2.5 * double(images.width), 3.5 * double(images.width)),
               y = this->random(points, -2.5 * double(images.height), 3.5 * double(images.height));
          for (auto* positions : {&x, &y})
            for (T& v : *positions) v = std::floor(v * 4) / 4 + T(0.0625);
          std::vector<T> out(static_cast<size_t>(images.count * images.channels * height * width)), fill;
          for (int64_t c = 0; c < images.channels; ++c) fill.push_back(T(0.5) + T(c));
          remap(image.data(), images, x.data(), height, width, y.data(), mode, padding, corners, fill.data(),
                images.channels, out.data());
          for (int64_t i = 0; i < int64_t(out.size()); ++i) {
            const int64_t p = i / (height * width),
                          at = p / images.channels * height * width + i % (height * width);
            const double u = placed(double(x[size_t(at)]), images.width, padding, corners),
                         v = placed(double(y[size_t(at)]), images.height, padding, corners);
            ASSERT_NEAR(double(out[size_t(i)]),
                        sampled(image.data() + p * plane, images.height, images.width, u, v, mode,
                                double(fill[size_t(p % images.channels)])),
                        1e-5)
                << images.height << "x" << images.width << " at " << x[size_t(at)] << ", " << y[size_t(at)]
                << ", padding " << int(padding);
          }
        }
}

TEST(NearestPixels, AreExactInTheWidestRows) {
  constexpr int64_t width = (1 << 24) - 1;
  std::vector<float> image(width);
  for (int64_t i = 0; i < width; ++i) image[size_t(i)] = float(i % 1000);
  for (const int64_t at : {(1 << 22) - 1, (1 << 22) + 1, (1 << 23) - 1, (1 << 23) + 1, (1 << 24) - 2}) {
    const float x = float(at), y = 0;
    float out = -1;
    remap(image.data(), {1, 1, 1, width}, &x, 1, 1, &y, Interpolation::kNearest, Padding::kZeros, true,
          &kNone<float>, 1, &out);
    EXPECT_EQ(out, float(at % 1000)) << at;
  }
}

KERNEL_CALL_BENCHMARK(remap, [] {
  return [image = kernel_benchmarks::random(3 * 1080 * 1920),
          x = kernel_benchmarks::random(1080 * 1920, 0, 1919),
          y = kernel_benchmarks::random(1080 * 1920, 0, 1079),
          out = std::vector<float>(3 * 1080 * 1920)]() mutable {
    remap(image.data(), {1, 3, 1080, 1920}, x.data(), 1080, 1920, y.data(), Interpolation::kBilinear,
          Padding::kZeros, true, &kNone<float>, 1, out.data());
  };
});

// In steps of 1/4, which OpenCV's tables of weights contain.
TYPED_TEST(Resampling, BicubicMatchesOpenCv) {
  using T = TypeParam;
  constexpr int height = 35, width = 133;
  for (const Images& images : kImages)
    for (const Padding padding : kPaddings)
      for (const bool corners : {true, false})
        for (const double step : {0.0, 0.75, 1.0}) {  // at random, and row by row
          const int64_t plane = images.height * images.width, points = images.count * height * width;
          const auto image = this->random(images.count * images.channels * plane, 0, 1);
          auto x = this->random(points, -2.5 * double(images.width), 3.5 * double(images.width)),
               y = this->random(points, -2.5 * double(images.height), 3.5 * double(images.height));
          for (int64_t i = 0; i < points; ++i) {
            if (step > 0) {
              x[size_t(i)] = T(step * double(i % width) + 0.25 * double(i / width % height) - 6);
              y[size_t(i)] = T(1.25 * double(i / width % height) - 3 + 0.25 * double(i % width / 9));
            }
            for (T* v : {&x[size_t(i)], &y[size_t(i)]}) *v = std::floor(*v * 4) / 4;
          }
          std::vector<T> out(static_cast<size_t>(images.count * images.channels * height * width));
          const T fill = T(0.75);
          remap(image.data(), images, x.data(), height, width, y.data(), Interpolation::kBicubic, padding,
                corners, &fill, 1, out.data());
          const int border = padding == Padding::kZeros    ? cv::BORDER_CONSTANT
                             : padding == Padding::kBorder ? cv::BORDER_REPLICATE
                             : corners                     ? cv::BORDER_REFLECT_101
                                                           : cv::BORDER_REFLECT;
          for (int64_t p = 0; p < images.count * images.channels; ++p) {
            const auto positions = [&](const std::vector<T>& all) {
              cv::Mat single;
              cv::Mat(height, width, cv::DataType<T>::type,
                      const_cast<T*>(all.data() + p / images.channels * height * width))
                  .convertTo(single, CV_32F);
              return single;
            };
            cv::Mat expected;
            cv::remap(cv::Mat(int(images.height), int(images.width), cv::DataType<T>::type,
                              const_cast<T*>(image.data() + p * plane)),
                      expected, positions(x), positions(y), cv::INTER_CUBIC, border, cv::Scalar(fill));
            const cv::Mat actual(height, width, cv::DataType<T>::type, out.data() + p * height * width);
            ASSERT_LE(cv::norm(actual, expected, cv::NORM_INF), 1e-5)
                << images.height << "x" << images.width << ", padding " << int(padding) << ", corners "
                << corners << ", step " << step;
          }
        }
}

// A position's value depends only on the position, not on its neighbours in the call.
TYPED_TEST(Resampling, BicubicIsTheSameBitsWhereverAPositionStands) {
  using T = TypeParam;
  constexpr int64_t width = 150;
  const Images images{1, 1, 40, 150};
  const auto image = this->random(40 * 150, 0, 1);
  std::vector<T> x, y;
  for (int64_t i = 0; i < width; ++i) {
    x.push_back(T(double(i) * 0.93 + 0.3));
    y.push_back(T(17.7 + 0.01 * double(i)));
  }
  std::vector<T> out(width);
  remap(image.data(), images, x.data(), 1, width, y.data(), Interpolation::kBicubic, Padding::kZeros, true,
        &kNone<T>, 1, out.data());
  for (size_t i = 0; i < size_t(width); ++i) {
    T alone;
    remap(image.data(), images, &x[i], 1, 1, &y[i], Interpolation::kBicubic, Padding::kZeros, true, &kNone<T>,
          1, &alone);
    ASSERT_EQ(out[i], alone) << i;
    std::vector<T> mixed_x(9, x[size_t(width) - 1 - i]), mixed_y(9, y[i]), mixed(9);  // far from each other
    mixed_x[3] = x[i];
    remap(image.data(), images, mixed_x.data(), 1, 9, mixed_y.data(), Interpolation::kBicubic,
          Padding::kZeros, true, &kNone<T>, 1, mixed.data());
    ASSERT_EQ(mixed[3], alone) << i;
  }
}

KERNEL_CALL_BENCHMARK(warp_perspective_bicubic, [] {
  return [image = kernel_benchmarks::random(3 * 1080 * 1920),
          out = std::vector<float>(3 * 1080 * 1920)]() mutable {
    const float matrix[9] = {0.98f, -0.17f, 150, 0.17f, 0.98f, -120, 0, 0, 1};
    warp_perspective(image.data(), {1, 3, 1080, 1920}, matrix, 1080, 1920, Interpolation::kBicubic,
                     Padding::kZeros, true, &kNone<float>, 1, out.data());
  };
});

KERNEL_CALL_BENCHMARK(warp_perspective_nearest, [] {
  return [image = kernel_benchmarks::random(24 * 256 * 256),
          out = std::vector<float>(24 * 256 * 256)]() mutable {
    const float matrix[9] = {0.98f, -0.17f, 20, 0.17f, 0.98f, -20, 0, 0, 1};
    for (int k = 0; k < 8; ++k)
      warp_perspective(image.data() + k * 3 * 65536, {1, 3, 256, 256}, matrix, 256, 256,
                       Interpolation::kNearest, Padding::kBorder, true, &kNone<float>, 1,
                       out.data() + k * 3 * 65536);
  };
});

TYPED_TEST(Resampling, RowsReadForwardsAcrossAllBordersAreTheirDefinition) {
  using T = TypeParam;
  constexpr int64_t height = 70, width = 190;
  const Images images{1, 2, 40, 150};
  const int64_t plane = images.height * images.width;
  const auto image = this->random(images.channels * plane, 0, 1);
  std::vector<T> x(height * width), y(x), out(static_cast<size_t>(images.channels * height * width));
  for (const double step : {0.0625, 0.9375, 1.0, 1.25})
    for (const double slope : {0.0, 0.03125, -0.03125, 1.0}) {
      for (int64_t i = 0; i < height * width; ++i) {
        const double u = double(i % width), v = double(i / width);
        x[size_t(i)] = T(u * step - 10.5 + 0.25 * v);
        y[size_t(i)] = T(0.75 * v - 3.5 + u * slope);
      }
      remap(image.data(), images, x.data(), height, width, y.data(), Interpolation::kBilinear,
            Padding::kZeros, true, &kNone<T>, 1, out.data());
      for (int64_t i = 0; i < int64_t(out.size()); ++i) {
        const size_t at = size_t(i % (height * width));
        const T* const source = image.data() + i / (height * width) * plane;
        ASSERT_NEAR(double(out[size_t(i)]),
                    sampled(source, images.height, images.width, double(x[at]), double(y[at]),
                            Interpolation::kBilinear),
                    1e-5)
            << "at " << x[at] << ", " << y[at] << ", step " << step << ", slope " << slope;
      }
    }
}

TYPED_TEST(Resampling, PositionsThatAreNoNumbersOrHugeReadNothing) {
  using T = TypeParam;
  const Images images{1, 1, 9, 9};
  const std::vector<T> image(81, T(1));
  constexpr T kInfinity = std::numeric_limits<T>::infinity();
  const std::vector<T> x{
      std::numeric_limits<T>::quiet_NaN(), kInfinity, -kInfinity, T(1e30), T(-1e30), T(4), T(4), T(4), T(4)},
      y(9, T(4));
  std::vector<T> out(9);
  for (const Interpolation mode : {Interpolation::kBilinear, Interpolation::kNearest}) {
    remap(image.data(), images, x.data(), 1, 9, y.data(), mode, Padding::kZeros, true, &kNone<T>, 1,
          out.data());
    EXPECT_EQ(out, (std::vector<T>{0, 0, 0, 0, 0, 1, 1, 1, 1}));
  }
}

TYPED_TEST(Resampling, WarpPerspectiveIsRemapAtTheMatrixesPositions) {
  using T = TypeParam;
  constexpr int64_t height = 37, width = 141;
  for (const Images& images : kImages) {
    const auto image = this->random(images.count * images.channels * images.height * images.width, 0, 1),
               noise = this->random(9 * images.count, -0.05, 0.05);
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
    warp_perspective(image.data(), images, matrices.data(), height, width, Interpolation::kBilinear,
                     Padding::kBorder, true, &kNone<T>, 1, out.data());
    remap(image.data(), images, x.data(), height, width, y.data(), Interpolation::kBilinear, Padding::kBorder,
          true, &kNone<T>, 1, expected.data());
    for (size_t i = 0; i < out.size(); ++i) ASSERT_NEAR(out[i], expected[i], 1e-5);
  }
}

KERNEL_BENCHMARK(warp_perspective, [](const float* x, Planes p, float* out) {
  const float matrix[] = {0.9f, 0.1f, 10, -0.1f, 0.9f, 20, 1e-5f, 1e-5f, 1};
  warp_perspective(x, {1, p.count, p.height, p.width}, matrix, p.height, p.width, Interpolation::kBilinear,
                   Padding::kZeros, true, &kNone<float>, 1, out);
});

// One plane, resized along both axes by taps(size, new size), against the result of `expected`.
template <class T, class Taps, class Expected>
void expect_resized(const std::vector<T>& x, const Planes& p, int64_t height, int64_t width, const Taps& taps,
                    const Expected& expected, double tolerance) {
  std::vector<T> out(static_cast<size_t>(p.count * height * width));
  resample(x.data(), p, taps(p.height, height), taps(p.width, width), out.data());
  for (int64_t i = 0; i < p.count; ++i) {
    const cv::Mat plane(int(p.height), int(p.width), cv::DataType<T>::type,
                        const_cast<T*>(x.data() + i * p.height * p.width));
    const cv::Mat actual(int(height), int(width), cv::DataType<T>::type, out.data() + i * height * width);
    EXPECT_LE(cv::norm(expected(plane, actual.size()), actual, cv::NORM_INF), tolerance)
        << p.height << "x" << p.width << " to " << height << "x" << width;
  }
}

const Planes kPlanes[] = {{1, 1, 1}, {2, 3, 5}, {1, 40, 71}, {1, 40, 142}, {2, 7, 1}, {3, 70, 150}};
const std::pair<int64_t, int64_t> kSizes[] = {{1, 1},   {2, 9},    {19, 33}, {20, 71},
                                              {19, 72}, {80, 142}, {5, 300}, {90, 4}};

TYPED_TEST(Resampling, ResizeMatchesOpenCv) {
  using T = TypeParam;
  for (const Planes& p : kPlanes)
    for (const auto& [height, width] : kSizes)
      for (const auto& [filter, flag] : {std::pair{Interpolation::kBilinear, cv::INTER_LINEAR},
                                         {Interpolation::kBicubic, cv::INTER_CUBIC}}) {
        const auto taps = [filter = filter](int64_t in, int64_t out) {
          return resize_taps<T>(in, out, filter, false, false);
        };
        const auto expected = [flag = flag](const cv::Mat& plane, cv::Size size) {
          cv::Mat resized;
          cv::resize(plane, resized, size, 0, 0, flag);
          return resized;
        };
        expect_resized(this->random(p.count * p.height * p.width, 0, 1), p, height, width, taps, expected,
                       2e-5);
      }
}

TYPED_TEST(Resampling, ResampledIsSumsByTables) {
  using T = TypeParam;
  for (const int64_t width : {1, 5, 70})
    for (const int64_t new_width : {1, 9, 40}) {
      const int64_t height = 7, new_height = 5, planes = 3, each = 4;
      const auto x = this->random(planes * height * width), down = this->random(new_height * each, -1, 1),
                 across = this->random(new_width * each, -1, 1);
      std::uniform_int_distribution<int64_t> draw(-2, 80);  // some are out of range
      std::vector<int64_t> rows(down.size()), columns(across.size());
      for (int64_t& row : rows) row = draw(this->engine_) % 9;
      for (int64_t& column : columns) column = draw(this->engine_);
      std::vector<T> out(static_cast<size_t>(planes * new_height * new_width));
      resampled(x.data(), {1, planes, height, width}, rows.data(), new_height, each, down.data(),
                columns.data(), new_width, each, across.data(), out.data());
      for (int64_t p = 0; p < planes; ++p)
        for (int64_t j = 0; j < new_height; ++j)
          for (int64_t i = 0; i < new_width; ++i) {
            double sum = 0;
            for (int64_t m = 0; m < each; ++m)
              for (int64_t k = 0; k < each; ++k) {
                const int64_t row = std::clamp<int64_t>(rows[size_t(j * each + m)], 0, height - 1),
                              column = std::clamp<int64_t>(columns[size_t(i * each + k)], 0, width - 1);
                sum += double(down[size_t(j * each + m)]) * across[size_t(i * each + k)] *
                       x[size_t((p * height + row) * width + column)];
              }
            ASSERT_NEAR(out[size_t((p * new_height + j) * new_width + i)], sum, 1e-5);
          }
    }
}

KERNEL_BENCHMARK(resampled, [](const float* x, Planes p, float* out) {
  std::vector<int64_t> rows, columns;
  for (int64_t y = 0; y < p.height / 2; ++y) rows.insert(rows.end(), {2 * y, 2 * y + 1});
  for (int64_t i = 0; i < p.width / 2; ++i) columns.insert(columns.end(), {2 * i, 2 * i + 1});
  const std::vector<float> down(rows.size(), 0.5f), across(columns.size(), 0.5f);
  resampled(x, {1, p.count, p.height, p.width}, rows.data(), p.height / 2, 2, down.data(), columns.data(),
            p.width / 2, 2, across.data(), out);
});
KERNEL_BENCHMARK(resize_half, [](const float* x, Planes p, float* out) {
  resize(x, {1, p.count, p.height, p.width}, p.height / 2, p.width / 2, Interpolation::kBilinear, false,
         false, out);
});

// In OpenCV, a blur then an interpolation, or the reverse order.
TYPED_TEST(Resampling, ResizeBlurredMatchesOpenCv) {
  using T = TypeParam;
  const std::vector<T> kernel{T(1) / 16, T(4) / 16, T(6) / 16, T(4) / 16, T(1) / 16};
  const std::pair<Border, int> borders[] = {{Border::kReflect, cv::BORDER_REFLECT_101},
                                            {Border::kReplicate, cv::BORDER_REPLICATE},
                                            {Border::kConstant, cv::BORDER_CONSTANT}};
  for (const Planes& p : {Planes{2, 4, 6}, Planes{1, 16, 34}, Planes{3, 70, 150}})
    for (const auto& [height, width] : {std::pair<int64_t, int64_t>{p.height / 2, p.width / 2},
                                        {p.height * 2 / 3, p.width * 2 / 3},
                                        {2 * p.height, 2 * p.width}})
      for (const auto& [border, flag] : borders)
        for (const bool before : {true, false}) {
          const auto taps = [&, border = border](int64_t in, int64_t out) {
            const auto plain = resize_taps<T>(in, out, Interpolation::kBilinear, false, false);
            return before ? blurred_before(plain, kernel, border, in) : blurred_after(plain, kernel, border);
          };
          const auto expected = [&, flag = flag](const cv::Mat& plane, cv::Size size) {
            cv::Mat made = plane.clone();
            if (!before) cv::resize(made, made, size, 0, 0, cv::INTER_LINEAR);
            cv::sepFilter2D(made, made, -1, kernel, kernel, {-1, -1}, 0, flag);
            if (before) cv::resize(made, made, size, 0, 0, cv::INTER_LINEAR);
            return made;
          };
          expect_resized(this->random(p.count * p.height * p.width, 0, 1), p, height, width, taps, expected,
                         2e-5);
        }
}

// An image in double, row by row.
using Rows = std::vector<std::vector<double>>;

Rows transposed(const Rows& rows) {
  Rows columns(rows[0].size(), std::vector<double>(rows.size()));
  for (size_t y = 0; y < rows.size(); ++y)
    for (size_t x = 0; x < rows[y].size(); ++x) columns[x][y] = rows[y][x];
  return columns;
}

// Each row's correlation with the taps.
Rows correlated(const Rows& rows, const std::vector<double>& taps, Border border) {
  const auto size = int64_t(rows[0].size()), length = int64_t(taps.size());
  Rows sums(rows.size(), std::vector<double>(rows[0].size(), 0.0));
  for (size_t y = 0; y < rows.size(); ++y)
    for (int64_t x = 0; x < size; ++x)
      for (int64_t k = 0; k < length; ++k) {
        int64_t at = x + k - length / 2;
        if (border == Border::kConstant && (at < 0 || at >= size)) continue;
        if (border == Border::kReplicate || size == 1) at = std::clamp<int64_t>(at, 0, size - 1);
        while (at < 0 || at >= size) at = at < 0 ? -at : 2 * (size - 1) - at;
        sums[y][size_t(x)] += taps[size_t(k)] * rows[y][size_t(at)];
      }
  return sums;
}

// Each row read at `width` positions between its pixels.
Rows interpolated(const Rows& rows, int64_t width, bool corners) {
  const auto size = int64_t(rows[0].size());
  Rows out(rows.size(), std::vector<double>(size_t(width)));
  for (size_t y = 0; y < rows.size(); ++y)
    for (int64_t x = 0; x < width; ++x) {
      const double position = corners ? double(x) * double(size - 1) / double(std::max<int64_t>(width - 1, 1))
                                      : (double(x) + 0.5) * double(size) / double(width) - 0.5;
      const double low = std::floor(position);
      const auto pixel = [&](double column) {
        return rows[y][size_t(std::clamp(column, 0.0, double(size - 1)))];
      };
      out[y][size_t(x)] = pixel(low) * (low + 1 - position) + pixel(low + 1) * (position - low);
    }
  return out;
}

TYPED_TEST(Resampling, ResizeBlurredIsABlurAndAResize) {
  using T = TypeParam;
  const std::vector<T> symmetric{T(1) / 16, T(4) / 16, T(6) / 16, T(4) / 16, T(1) / 16};
  std::vector<std::pair<int64_t, int64_t>> sizes(std::begin(kSizes), std::end(kSizes));
  sizes.insert(sizes.end(), {{20, 75}, {40, 150}});  // half of the largest image, and its own size
  for (const Images& images : kImages)
    for (const std::vector<T>& blur : {symmetric, std::vector<T>{T(0.75)}, this->random(3, -0.4, 0.6),
                                       this->random(9, -0.4, 0.6)})  // also longer than most images
      for (const auto& [height, width] : sizes)
        for (const Border border : {Border::kReflect, Border::kReplicate, Border::kConstant})
          for (const bool corners : {false, true})
            for (const bool before : {false, true}) {
              const int64_t planes = images.count * images.channels;
              const auto x = this->random(planes * images.height * images.width, -1, 1);
              std::vector<T> out(size_t(planes * height * width));
              resize_blurred(x.data(), images, blur.data(), int64_t(blur.size()), height, width, corners,
                             border, before, out.data());
              const std::vector<double> taps(blur.begin(), blur.end());
              const auto blurred = [&](const Rows& of) {
                return transposed(correlated(transposed(correlated(of, taps, border)), taps, border));
              };
              const auto resized = [&, height = height, width = width](const Rows& of) {
                return transposed(
                    interpolated(transposed(interpolated(of, width, corners)), height, corners));
              };
              for (int64_t p = 0; p < planes; ++p) {
                Rows rows;
                for (int64_t y = p * images.height; y < (p + 1) * images.height; ++y)
                  rows.emplace_back(x.begin() + y * images.width, x.begin() + (y + 1) * images.width);
                const Rows expected = before ? resized(blurred(rows)) : blurred(resized(rows));
                for (int64_t i = 0; i < height * width; ++i)
                  ASSERT_NEAR(double(out[size_t(p * height * width + i)]),
                              expected[size_t(i / width)][size_t(i % width)],
                              (std::is_same_v<T, float> ? 1e-5 : 1e-12))
                      << images.height << "x" << images.width << " to " << height << "x" << width << ", "
                      << taps.size() << " taps, border " << int(border) << ", corners " << corners
                      << ", before " << before << ", " << i % width << " " << i / width;
              }
            }
}

KERNEL_BENCHMARK(resize_blurred_half, [](const float* x, Planes p, float* out) {
  const float taps[] = {0.0625f, 0.25f, 0.375f, 0.25f, 0.0625f};
  resize_blurred(x, {1, p.count, p.height, p.width}, taps, 5, p.height / 2, p.width / 2, false,
                 Border::kReflect, true, out);
});

// Keys' cubic with a = -1/2, as in Pillow's reduction.
double keys(double d) {
  return d < 1 ? (1.5 * d - 2.5) * d * d + 1 : d < 2 ? ((-0.5 * d + 2.5) * d - 4) * d + 2 : 0;
}

TYPED_TEST(Resampling, AntialiasedTapsAreTheStretchedFilter) {
  using T = TypeParam;
  for (const auto& [in, out] :
       {std::pair<int64_t, int64_t>{40, 13}, {41, 7}, {100, 3}, {9, 1}, {10, 25}, {1, 3}})
    for (const Interpolation filter : {Interpolation::kBilinear, Interpolation::kBicubic})
      for (const bool corners : {false, true}) {
        const Taps<T> taps = resize_taps<T>(in, out, filter, corners, true);
        const double factor =
            corners ? double(in - 1) / double(std::max<int64_t>(out - 1, 1)) : double(in) / double(out);
        for (int64_t i = 0; i < out; ++i) {
          std::vector<double> expected(size_t(in), 0.0), actual(size_t(in), 0.0);
          double total = 0;
          for (int64_t j = 0; j < in; ++j) {
            const double d = std::abs(double(j) + 0.5 - (double(i) + 0.5) * factor) / std::max(factor, 1.0);
            total += expected[size_t(j)] =
                filter == Interpolation::kBilinear ? std::max(1 - d, 0.0) : keys(d);
          }
          for (int64_t k = i * taps.each; k < (i + 1) * taps.each; ++k)
            actual[size_t(taps.index[size_t(k)])] += double(taps.weight[size_t(k)]);
          for (size_t j = 0; j < size_t(in); ++j)
            EXPECT_NEAR(actual[j], expected[j] / total, 2e-6)
                << in << " to " << out << ", corners " << corners << ", pixel " << j << " of " << i;
        }
      }
}

TYPED_TEST(Resampling, WithCornersARampStaysOneAndNearestTakesThePixelBelow) {
  using T = TypeParam;
  for (const auto& [in, out] : {std::pair<int64_t, int64_t>{9, 17}, {17, 5}, {30, 30}, {5, 1}}) {
    const Taps<T> linear = resize_taps<T>(in, out, Interpolation::kBilinear, true, false),
                  nearest = resize_taps<T>(in, out, Interpolation::kNearest, false, false);
    for (int64_t i = 0; i < out; ++i) {
      double position = 0;
      for (int64_t k = 0; k < 2; ++k)
        position += double(linear.weight[size_t(2 * i + k)]) * double(linear.index[size_t(2 * i + k)]);
      EXPECT_NEAR(position, double(i * (in - 1)) / double(std::max<int64_t>(out - 1, 1)), 1e-5);
      EXPECT_EQ(nearest.index[size_t(i)], int(std::floor(double(i) * double(in) / double(out) + 1e-9)));
    }
  }
}

}  // namespace
