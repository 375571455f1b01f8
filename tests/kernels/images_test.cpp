// The kernels alone, against OpenCV or the definition in plain loops of doubles, at sizes that leave parts of
// vectors and tiles.
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "benchmarks.h"
#include "fixture.h"
#include "kernels.h"

using namespace chiasm::kernels;

namespace {

constexpr Border kBorders[] = {Border::kReflect, Border::kReplicate, Border::kCircular, Border::kConstant};
constexpr int kOpenCvBorders[] = {cv::BORDER_REFLECT_101, cv::BORDER_REPLICATE, cv::BORDER_WRAP,
                                  cv::BORDER_CONSTANT};
// (planes, height, width): a pixel, less than a vector, odd sizes, more than a tile's rows, and more than a
// strip's columns.
const Planes kSizes[] = {{1, 1, 1}, {2, 3, 5}, {3, 9, 17}, {2, 70, 33}, {1, 3, 30011}};

template <class T>
class Kernels : public KernelsTest<T> {
 protected:
  Kernels() : KernelsTest<T>(7) {}
};

using Types = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Kernels, Types);

int64_t pixels(const Planes& p) { return p.count * p.height * p.width; }

template <class T>
cv::Mat plane(const std::vector<T>& values, const Planes& p, int64_t i) {
  return cv::Mat(int(p.height), int(p.width), cv::DataType<T>::type,
                 const_cast<T*>(values.data() + i * p.height * p.width));
}

// Compares `actual` with OpenCV's `filter` of each plane with a border of ry, rx pixels around it.
template <class T>
void expect_filtered(const std::vector<T>& x, const std::vector<T>& actual, const Planes& p, int ry, int rx,
                     int border, double value, double tolerance,
                     const std::function<cv::Mat(const cv::Mat&, int64_t)>& filter) {
  for (int64_t i = 0; i < p.count; ++i) {
    cv::Mat padded;
    cv::copyMakeBorder(plane(x, p, i), padded, ry, ry, rx, rx, border, cv::Scalar(value));
    const cv::Mat expected = filter(padded, i)(cv::Rect(rx, ry, int(p.width), int(p.height)));
    EXPECT_LE(cv::norm(expected, plane(actual, p, i), cv::NORM_INF), tolerance)
        << p.height << "x" << p.width << ", border " << border;
  }
}

TYPED_TEST(Kernels, SeparableMatchesOpenCv) {
  using T = TypeParam;
  for (const Planes& p : kSizes)
    for (int b = 0; b < 4; ++b)
      for (const bool shared : {true, false}) {
        const auto x = this->random(pixels(p));
        auto column = this->random(5 * p.count, -1, 1), row = this->random(3 * p.count, -1, 1);
        if (shared) row[2] = row[0], column[4] = column[0], column[3] = column[1];  // symmetric
        std::vector<T> out(x.size());
        separable(x.data(), {p.count, 1, p.height, p.width}, column.data(), shared ? 1 : p.count, 5,
                  row.data(), shared ? 1 : p.count, 3, kBorders[b], T(2), T(-0.5), out.data());
        expect_filtered<T>(x, out, p, 2, 1, kOpenCvBorders[b], 0, 1e-5,
                           [&](const cv::Mat& padded, int64_t i) {
                             const auto taps = [&](const std::vector<T>& all, int n) {
                               return cv::Mat(1, n, cv::DataType<T>::type,
                                              const_cast<T*>(all.data() + (shared ? 0 : i * n)));
                             };
                             cv::Mat result;
                             cv::sepFilter2D(padded, result, -1, taps(row, 3), taps(column, 5));
                             return cv::Mat(2 * result - 0.5 * padded);
                           });
      }
}

constexpr float kGaussian[] = {0.0614f, 0.2448f, 0.3876f, 0.2448f, 0.0614f}, kOnes[5] = {1, 1, 1, 1, 1};
KERNEL_BENCHMARK(separable_5x5, [](const float* x, Planes p, float* out) {
  separable(x, {1, p.count, p.height, p.width}, kGaussian, 1, 5, kGaussian, 1, 5, Border::kReflect, 1.0f,
            0.0f, out);
});
KERNEL_BENCHMARK(separable_box_5x5, [](const float* x, Planes p, float* out) {
  separable(x, {1, p.count, p.height, p.width}, kOnes, 1, 5, kOnes, 1, 5, Border::kReflect, 0.04f, 0.0f, out);
});

TYPED_TEST(Kernels, Correlate2dMatchesOpenCv) {
  using T = TypeParam;
  for (const Planes& p : kSizes)
    for (int b = 0; b < 4; ++b)
      for (const bool shared : {true, false})
        for (const cv::Size size : {cv::Size(3, 3), cv::Size(1, 1), cv::Size(4, 2)}) {
          const auto x = this->random(pixels(p)), taps = this->random(size.area() * p.count, -1, 1);
          std::vector<T> out(x.size());
          correlate2d(x.data(), {p.count, 1, p.height, p.width}, taps.data(), shared ? 1 : p.count,
                      size.height, size.width, kBorders[b], out.data());
          expect_filtered<T>(
              x, out, p, 2, 2, kOpenCvBorders[b], 0, 1e-5, [&](const cv::Mat& padded, int64_t i) {
                const cv::Mat kernel(size, cv::DataType<T>::type,
                                     const_cast<T*>(taps.data() + (shared ? 0 : i * size.area())));
                cv::Mat result;
                cv::filter2D(padded, result, -1, kernel,
                             cv::Point((size.width - 1) / 2, (size.height - 1) / 2));
                return result;
              });
        }
}

constexpr float kTaps[9] = {0.1f, 0.2f, 0.3f, 0.15f, 0.25f, 0.35f, 0.12f, 0.22f, 0.32f};
KERNEL_BENCHMARK(correlate2d_3x3, [](const float* x, Planes p, float* out) {
  correlate2d(x, {1, p.count, p.height, p.width}, kTaps, 1, 3, 3, Border::kReflect, out);
});

TYPED_TEST(Kernels, Correlate3dMatchesTheDefinition) {
  using T = TypeParam;
  constexpr int64_t kBatch = 2, kChannels = 2;
  for (const auto& [d, h, w] : {std::array<int64_t, 3>{1, 1, 1}, {5, 4, 9}, {4, 70, 37}})
    for (const auto& [kz, ky, kx] : {std::array<int64_t, 3>{3, 3, 3}, {1, 1, 1}, {2, 4, 3}})
      for (int b = 0; b < 4; ++b)
        for (const bool shared : {true, false}) {
          const int64_t volume = d * h * w, window = kz * ky * kx;
          const auto x = this->random(kBatch * kChannels * volume),
                     taps = this->random(kBatch * window, -1, 1);
          std::vector<T> out(x.size());
          correlate3d(x.data(), kBatch, kChannels, d, h, w, taps.data(), shared ? 1 : kBatch, kz, ky, kx,
                      kBorders[b], out.data());
          const auto place = [b](int64_t i, int64_t size) {
            return cv::borderInterpolate(static_cast<int>(i), static_cast<int>(size), kOpenCvBorders[b]);
          };
          for (int64_t i = 0; i < static_cast<int64_t>(x.size()); ++i) {
            const int64_t image = i / volume, z = i / (h * w) % d, y = i / w % h, column = i % w;
            double sum = 0;
            for (int64_t k = 0; k < window; ++k) {
              const int64_t u = place(z + k / (ky * kx) - (kz - 1) / 2, d),
                            v = place(y + k / kx % ky - (ky - 1) / 2, h),
                            s = place(column + k % kx - (kx - 1) / 2, w);
              if (u < 0 || v < 0 || s < 0) continue;
              sum += double(x[image * volume + (u * h + v) * w + s]) *
                     double(taps[(shared ? 0 : image / kChannels) * window + k]);
            }
            ASSERT_NEAR(out[i], sum, 1e-5) << d << " " << h << " " << w << ", border " << b;
          }
        }
}

KERNEL_CALL_BENCHMARK(correlate3d_3x3x3, [] {
  return [x = kernel_benchmarks::random(64 * 128 * 128), taps = kernel_benchmarks::random(27),
          out = std::vector<float>(64 * 128 * 128)]() mutable {
    correlate3d(x.data(), 1, 1, 64, 128, 128, taps.data(), 1, 3, 3, 3, Border::kReflect, out.data());
  };
});

TYPED_TEST(Kernels, SobelMatchesOpenCv) {
  using T = TypeParam;
  for (const Planes& p : kSizes) {
    const auto x = this->random(pixels(p));
    std::vector<T> out(x.size());
    sobel(x.data(), p, T(0.125), T(0.5), out.data());
    expect_filtered<T>(x, out, p, 1, 1, cv::BORDER_REPLICATE, 0, 1e-6, [](const cv::Mat& padded, int64_t) {
      cv::Mat dx, dy, result;
      cv::Sobel(padded, dx, -1, 1, 0, 3, 0.125);
      cv::Sobel(padded, dy, -1, 0, 1, 3, 0.125);
      cv::sqrt(dx.mul(dx) + dy.mul(dy) + 0.5, result);
      return result;
    });
  }
}

KERNEL_BENCHMARK(sobel, [](const float* x, Planes p, float* out) { sobel(x, p, 0.125f, 1e-6f, out); });

TYPED_TEST(Kernels, IntegralMatchesOpenCv) {
  using T = TypeParam;
  for (const Planes& p : kSizes) {
    const auto x = this->random(pixels(p), -1, 1);
    std::vector<T> out(x.size());
    integral(x.data(), p, out.data());
    for (int64_t i = 0; i < p.count; ++i) {
      cv::Mat sums;
      cv::integral(plane(x, p, i), sums, CV_64F);
      cv::Mat expected;
      sums(cv::Rect(1, 1, int(p.width), int(p.height))).convertTo(expected, cv::DataType<T>::type);
      EXPECT_LE(cv::norm(expected, plane(out, p, i), cv::NORM_INF),
                (sizeof(T) == 4 ? 1e-6 : 1e-14) * double(p.height * p.width));
    }
  }
}

KERNEL_BENCHMARK(integral, [](const float* x, Planes p, float* out) { integral(x, p, out); });

TYPED_TEST(Kernels, CannyHysteresisKeepsComponentsWithAStrongPixel) {
  using T = TypeParam;
  for (const Planes& p : kSizes) {
    const auto x = this->random(pixels(p));
    const T low = T(0.6), high = T(0.97);
    const std::unique_ptr<bool[]> out(new bool[x.size()]);
    canny_hysteresis(x.data(), p, low, high, out.get());
    for (int64_t i = 0; i < p.count; ++i) {
      const cv::Mat values = plane(x, p, i);
      cv::Mat labels;
      cv::connectedComponents(values > low, labels, 8);
      std::vector<bool> strong(x.size() + 1);
      for (int k = 0; k < int(values.total()); ++k)
        if (values.at<T>(k / values.cols, k % values.cols) > high)
          strong[size_t(labels.at<int>(k / values.cols, k % values.cols))] = true;
      for (int k = 0; k < int(values.total()); ++k) {
        const int label = labels.at<int>(k / values.cols, k % values.cols);
        ASSERT_EQ(out[size_t(i * p.height * p.width + k)], label > 0 && strong[size_t(label)]);
      }
    }
  }
}

KERNEL_CALL_BENCHMARK(canny_hysteresis, [] {
  return [x = kernel_benchmarks::random(1080 * 1920), out = std::shared_ptr<bool[]>(new bool[1080 * 1920])] {
    canny_hysteresis(x.data(), {1, 1080, 1920}, 0.6f, 0.9f, out.get());
  };
});

TYPED_TEST(Kernels, CannyNmsKeepsMaximaOfOpenCvsGradientAcrossTheEdge) {
  using T = TypeParam;
  for (const Planes& p : kSizes) {
    const auto x = this->random(pixels(p));
    std::vector<T> out(x.size());
    canny_nms(x.data(), p, T(0), out.data());
    for (int64_t i = 0; i < p.count; ++i) {
      cv::Mat dx, dy, magnitude;
      cv::Sobel(plane(x, p, i), dx, CV_64F, 1, 0, 3, 1, 0, cv::BORDER_REPLICATE);
      cv::Sobel(plane(x, p, i), dy, CV_64F, 0, 1, 3, 1, 0, cv::BORDER_REPLICATE);
      cv::magnitude(dx, dy, magnitude);
      cv::copyMakeBorder(magnitude, magnitude, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
      int unlike = 0;
      for (int r = 0; r < dx.rows; ++r)
        for (int c = 0; c < dx.cols; ++c) {
          const double gx = dx.at<double>(r, c), gy = dy.at<double>(r, c),
                       m = magnitude.at<double>(r + 1, c + 1);
          const double angle = std::atan2(std::abs(gy), std::abs(gx)) * 180 / CV_PI;
          const int down = angle < 22.5 ? 0 : 1, right = angle > 67.5                        ? 0
                                                         : down == 0 || (gx > 0) == (gy > 0) ? 1
                                                                                             : -1;
          const double before = magnitude.at<double>(r + 1 - down, c + 1 - right),
                       after = magnitude.at<double>(r + 1 + down, c + 1 + right);
          const double expected = m > before && (down && right ? m > after : m >= after) ? m : 0;
          unlike += std::abs(expected - out[size_t((i * p.height + r) * p.width + c)]) > 1e-5;
        }
      EXPECT_LE(unlike, dx.total() / 20000)
          << p.height << "x" << p.width;  // values whose comparison depends on rounding
    }
  }
}

KERNEL_BENCHMARK(canny_nms, [](const float* x, Planes p, float* out) { canny_nms(x, p, 1e-6f, out); });

TYPED_TEST(Kernels, BilateralMatchesItsDefinition) {
  using T = TypeParam;
  constexpr int64_t ky = 3, kx = 5, channels = 2, depth = 3;
  for (const Planes& p : kSizes)
    for (const Border border : kBorders)
      for (const bool squares : {true, false}) {
        const auto x = this->random(pixels(p) * channels), guide = this->random(pixels(p) * depth),
                   space_weights = this->random(ky * kx * p.count, 0.5, 1);
        auto symmetric = space_weights;  // like every window of distances
        for (int64_t n = 0; n < p.count; ++n)
          for (int64_t k = 0; k < ky * kx; ++k)
            symmetric[size_t(n * ky * kx + k)] =
                space_weights[size_t(n * ky * kx + std::min(k, ky * kx - 1 - k))];
        const auto range_coefficient = this->random(p.count, -20, -1);
        std::vector<T> out(x.size());
        bilateral(x.data(), {p.count, channels, p.height, p.width}, guide.data(), p.count, depth,
                  symmetric.data(), p.count, ky, kx, range_coefficient.data(), p.count, border, squares,
                  out.data());
        const auto at = [&](const std::vector<T>& values, int64_t i, int64_t r, int64_t c) {
          const int v = cv::borderInterpolate(int(r), int(p.height), kOpenCvBorders[int(border)]),
                    u = cv::borderInterpolate(int(c), int(p.width), kOpenCvBorders[int(border)]);
          return v < 0 || u < 0 ? 0.0 : double(values[size_t((i * p.height + v) * p.width + u)]);
        };
        for (int64_t n = 0; n < p.count; ++n)
          for (int64_t r = 0; r < p.height; ++r)
            for (int64_t c = 0; c<p.width; c += p.width> 100 ? 29 : 1) {
              double total = 0, sums[channels] = {};
              for (int64_t k = 0; k < ky * kx; ++k) {
                const int64_t v = r + k / kx - ky / 2, u = c + k % kx - kx / 2;
                double distance = 0;
                for (int64_t d = 0; d < depth; ++d) {
                  const double difference =
                      std::abs(at(guide, n * depth + d, v, u) - at(guide, n * depth + d, r, c));
                  distance += squares ? difference * difference : difference;
                }
                const double weight = std::exp(double(range_coefficient[size_t(n)]) *
                                               (squares ? distance : distance * distance)) *
                                      double(symmetric[size_t(n * ky * kx + k)]);
                total += weight;
                for (int64_t i = 0; i < channels; ++i) sums[i] += weight * at(x, n * channels + i, v, u);
              }
              for (int64_t i = 0; i < channels; ++i)
                ASSERT_NEAR(out[size_t(((n * channels + i) * p.height + r) * p.width + c)], sums[i] / total,
                            1e-5)
                    << p.height << "x" << p.width;
            }
      }
}

KERNEL_BENCHMARK(bilateral_5x5, [](const float* x, Planes p, float* out) {
  const std::vector<float> weights(25, 0.5f);
  const float coefficient = -50;
  bilateral(x, {p.count / 3, 3, p.height, p.width}, x, p.count / 3, 3, weights.data(), 1, 5, 5, &coefficient,
            1, Border::kReflect, false, out);
});

class Frames : public Kernels<float> {};

TEST_F(Frames, FrameToGreyMatchesOpenCv) {
  for (const int64_t n : {1, 7, 8, 9, 10, 31, 8191, 8201, 20011}) {
    cv::Mat frame(1, int(n), CV_8UC3), numbers, luma;
    cv::randu(frame, 0, 256);
    frame.convertTo(numbers, CV_32F);
    cv::cvtColor(numbers, luma, cv::COLOR_BGR2GRAY);
    std::vector<float> grey(static_cast<size_t>(n));
    frame_to_grey(frame.data, 1, n, grey.data());
    EXPECT_LE(cv::norm(luma, cv::Mat(1, int(n), CV_32F, grey.data()), cv::NORM_INF), 1e-4) << n;
  }
}

KERNEL_CALL_BENCHMARK(frame_to_grey, [] {
  return [x = std::vector<uint8_t>(3 * 1080 * 1920, 7), out = std::vector<float>(1080 * 1920)]() mutable {
    frame_to_grey(x.data(), 1080, 1920, out.data());
  };
});

TEST_F(Frames, ResizeFrameMatchesOpenCv) {
  for (const cv::Size size :
       {cv::Size(2, 1), cv::Size(5, 8), cv::Size(37, 21), cv::Size(256, 256), cv::Size(301, 133)})
    for (const cv::Size to : {cv::Size(1, 1), cv::Size(3, 2), cv::Size(37, 21), cv::Size(224, 224)}) {
      // In its own memory, so that a sanitizer detects reads outside.
      std::vector<uint8_t> bytes(static_cast<size_t>(3 * size.area()));
      cv::Mat frame(size, CV_8UC3, bytes.data()), numbers, resized;
      cv::randu(frame, 0, 256);
      frame.convertTo(numbers, CV_32F);
      cv::resize(numbers, resized, to, 0, 0, cv::INTER_LINEAR);  // OpenCV rounds positions to float
      std::vector<cv::Mat> channels;
      cv::split(resized, channels);
      std::vector<float> planes(static_cast<size_t>(3 * to.area()));
      resize_frame(bytes.data(), size.height, size.width, to.height, to.width, planes.data());
      for (int c = 0; c < 3; ++c)
        EXPECT_LE(cv::norm(channels[size_t(2 - c)], cv::Mat(to, CV_32F, planes.data() + c * to.area()),
                           cv::NORM_INF),
                  1e-2)
            << size << " to " << to;
    }
}

KERNEL_CALL_BENCHMARK(resize_frame, [] {
  return [x = std::vector<uint8_t>(3 * 1080 * 1920, 7), out = std::vector<float>(3 * 224 * 224)]() mutable {
    resize_frame(x.data(), 1080, 1920, 224, 224, out.data());
  };
});

TYPED_TEST(Kernels, QuantizeU8AndRowHistogramsMatchTheirDefinitions) {
  using T = TypeParam;
  const int64_t n = 200003;
  auto x = this->random(n, -0.1, 1.1);
  x[0] = std::nan("");
  x[1] = T(0.5);
  std::vector<uint8_t> levels(x.size());
  quantize_u8(x.data(), n, levels.data());
  for (size_t i = 1; i < x.size(); ++i) {
    const float scaled = static_cast<float>(x[i]) * 255.0f;
    ASSERT_EQ(levels[i], std::clamp(std::floor(double(scaled) + 0.5), 0.0, 255.0)) << x[i];
  }
  EXPECT_EQ(levels[0], 0);

  std::vector<int32_t> counts(2 * 10);
  const T low[] = {T(-0.1), T(0.25)}, span[] = {T(1.2), T(0.5)};
  auto values = this->random(2 * n, 0.25, 0.75);
  values[0] = T(1.1);  // the end belongs to the last bin
  row_histograms(values.data(), 2, n, low, span, 10, counts.data());
  for (int row = 0; row < 2; ++row) {
    std::vector<int32_t> expected(10);
    for (int64_t i = 0; i < n; ++i)
      ++expected[std::min<size_t>(size_t((values[size_t(row * n + i)] - low[row]) / span[row] * T(10)), 9)];
    EXPECT_EQ(expected, std::vector<int32_t>(counts.begin() + row * 10, counts.begin() + row * 10 + 10));
  }
}

KERNEL_CALL_BENCHMARK(quantize_u8, [] {
  return [x = kernel_benchmarks::random(3 * 1080 * 1920),
          out = std::vector<uint8_t>(3 * 1080 * 1920)]() mutable {
    quantize_u8(x.data(), 3 * 1080 * 1920, out.data());
  };
});
KERNEL_CALL_BENCHMARK(row_histograms, [] {
  return [x = kernel_benchmarks::random(3 * 1080 * 1920), low = std::vector<float>(3),
          span = std::vector<float>(3, 1), out = std::vector<int32_t>(3 * 256)]() mutable {
    row_histograms(x.data(), 3, 1080 * 1920, low.data(), span.data(), 256, out.data());
  };
});

TYPED_TEST(Kernels, AminmaxMatchesTheStandardLibraryAndPassesNaNOn) {
  using T = TypeParam;
  for (const int64_t n : {1, 7, 65, 200003}) {
    auto x = this->random(3 * n, -5, 5);
    x[size_t(n)] = std::nan("");
    x[size_t(2 * n)] = INFINITY;
    std::vector<T> out(6);
    aminmax(x.data(), 3, n, out.data());
    for (const int64_t row : {0, 2}) {
      EXPECT_EQ(out[size_t(row)], *std::min_element(x.begin() + row * n, x.begin() + (row + 1) * n));
      EXPECT_EQ(out[size_t(3 + row)], *std::max_element(x.begin() + row * n, x.begin() + (row + 1) * n));
    }
    EXPECT_TRUE(std::isnan(out[1]) && std::isnan(out[4]));
  }
}

KERNEL_CALL_BENCHMARK(aminmax, [] {
  return [x = kernel_benchmarks::random(3 * 1080 * 1920), out = std::vector<float>(6)]() mutable {
    aminmax(x.data(), 3, 1080 * 1920, out.data());
  };
});

class Tables : public Kernels<float> {};

TEST_F(Tables, BincountMatchesOpenCv) {
  const int64_t rows = 2, n = 100003;
  std::vector<uint8_t> bytes(size_t(rows * n));
  for (auto& b : bytes) b = uint8_t(this->engine_() % 251);
  const std::vector<int32_t> index(bytes.begin(), bytes.end());
  std::vector<int32_t> counts(rows * 256), others(rows * 300);
  bincount(bytes.data(), rows, n, 256, counts.data());
  bincount(index.data(), rows, n, 300, others.data());
  for (int64_t row = 0; row < rows; ++row) {
    const cv::Mat values(1, int(n), CV_8U, bytes.data() + row * n);
    const int channel = 0, size = 256;
    const float range[] = {0, 256}, *ranges = range;
    cv::Mat histogram;
    cv::calcHist(&values, 1, &channel, {}, histogram, 1, &size, &ranges);
    for (int k = 0; k < 256; ++k) {
      EXPECT_EQ(counts[size_t(row * 256 + k)], histogram.at<float>(k));
      EXPECT_EQ(others[size_t(row * 300 + k)], histogram.at<float>(k));
    }
  }
  // indices beyond the last bin are not counted, and nothing is written for them
  bincount(index.data(), rows, n, 100, others.data());
  EXPECT_EQ(others[99], counts[99]);
}

KERNEL_CALL_BENCHMARK(bincount, [] {
  return [x = std::vector<uint8_t>(3 * 1080 * 1920, 7), out = std::vector<int32_t>(3 * 256)]() mutable {
    bincount(x.data(), 3, 1080 * 1920, 256, out.data());
  };
});

TEST_F(Tables, LutTakesEachRowsTable) {
  const int64_t n = 70001;
  const auto table = this->random(2 * 256);
  std::vector<uint8_t> index(size_t(2 * n));
  for (auto& i : index) i = uint8_t(this->engine_());
  std::vector<float> out(index.size());
  lut(table.data(), 2, index.data(), n, out.data());
  for (size_t i = 0; i < index.size(); ++i) ASSERT_EQ(out[i], table[i / size_t(n) * 256 + index[i]]);
}

KERNEL_CALL_BENCHMARK(lut, [] {
  return [table = kernel_benchmarks::random(3 * 256), x = std::vector<uint8_t>(3 * 1080 * 1920, 7),
          out = std::vector<float>(3 * 1080 * 1920)]() mutable {
    lut(table.data(), 3, x.data(), 1080 * 1920, out.data());
  };
});

// Both kernels of CLAHE give OpenCV's result, with tables made from the tiles' counts by OpenCV's rules.
TEST_F(Tables, ClaheMatchesOpenCv) {
  for (const Planes& p : {Planes{2, 32, 48}, Planes{1, 61, 77}}) {
    const int64_t tiles_y = 3, tiles_x = 4, tiles = tiles_y * tiles_x;
    const bool whole = p.height % tiles_y == 0 && p.width % tiles_x == 0;
    const int64_t tile_y = whole ? p.height / tiles_y : (p.height + tiles_y - p.height % tiles_y) / tiles_y;
    const int64_t tile_x = whole ? p.width / tiles_x : (p.width + tiles_x - p.width % tiles_x) / tiles_x;
    std::vector<uint8_t> levels(size_t(pixels(p))), out(levels.size());
    for (auto& v : levels) v = uint8_t(this->engine_() % 90 + this->engine_() % 90);
    std::vector<int32_t> counts(size_t(p.count * tiles * 256));
    clahe_histograms(levels.data(), p.count, p.height, p.width, tile_y, tile_x, tiles_y, tiles_x,
                     counts.data());
    std::vector<float> table(counts.size());
    for (size_t t = 0; t < counts.size(); t += 256)
      for (size_t k = 0, sum = 0; k < 256; ++k)
        table[t + k] =
            std::nearbyint(float(sum += size_t(counts[t + k])) * (255.0f / float(tile_y * tile_x)));
    const auto axis = [](int64_t size, int64_t tile, int64_t count, std::vector<int64_t>& first,
                         std::vector<int64_t>& second, std::vector<float>& weight) {
      for (int64_t i = 0; i < size; ++i) {
        const float position = float(i) * (1.0f / float(tile)) - 0.5f;
        const auto lower = int64_t(std::floor(position));
        first.push_back(std::max<int64_t>(lower, 0));
        second.push_back(std::min(lower + 1, count - 1));
        weight.push_back(position - float(lower));
      }
    };
    std::vector<int64_t> y0, y1, x0, x1;
    std::vector<float> wy, wx;
    axis(p.height, tile_y, tiles_y, y0, y1, wy);
    axis(p.width, tile_x, tiles_x, x0, x1, wx);
    clahe_interpolate(table.data(), p.count, tiles, tiles_x, levels.data(), p.height, p.width, y0.data(),
                      y1.data(), wy.data(), x0.data(), x1.data(), wx.data(), out.data());
    const auto clahe = cv::createCLAHE(0, {int(tiles_x), int(tiles_y)});
    for (int64_t i = 0; i < p.count; ++i) {
      cv::Mat expected;
      clahe->apply(plane(levels, p, i), expected);
      EXPECT_EQ(cv::norm(expected, plane(out, p, i), cv::NORM_INF), 0);
    }
  }
}

KERNEL_CALL_BENCHMARK(clahe_histograms, [] {
  return [x = std::vector<uint8_t>(1080 * 1920, 7), out = std::vector<int32_t>(64 * 256)]() mutable {
    clahe_histograms(x.data(), 1, 1080, 1920, 135, 240, 8, 8, out.data());
  };
});
KERNEL_CALL_BENCHMARK(clahe_interpolate, [] {
  return [curves = kernel_benchmarks::random(64 * 256, 0, 255), x = std::vector<uint8_t>(1080 * 1920, 7),
          tiles = std::vector<int64_t>(1920, 3), weights = std::vector<float>(1920, 0.5f),
          out = std::vector<uint8_t>(1080 * 1920)]() mutable {
    clahe_interpolate(curves.data(), 1, 64, 8, x.data(), 1080, 1920, tiles.data(), tiles.data(),
                      weights.data(), tiles.data(), tiles.data(), weights.data(), out.data());
  };
});

}  // namespace
