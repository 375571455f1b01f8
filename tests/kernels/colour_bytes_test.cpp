// Colours of bytes, interleaved and in planes, against OpenCV or their definition.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "bytes.h"

using namespace chiasm::kernels;

namespace {

TEST_F(Bytes, PixelsAreSplitAndJoinedAsOpenCvDoes) {
  for (const int channels : {1, 2, 3, 4, 5})
    for (const int pixels : {1, 15, 33, 4096 + 70}) {
      const cv::Mat image = frame(1, pixels, channels);
      const auto values = static_cast<size_t>(pixels * channels);
      std::vector<uint8_t> planes(values), back(values);
      split_pixels(image.data, 1, pixels * channels, channels, planes.data());
      std::vector<cv::Mat> expected;
      cv::split(image, expected);
      for (int c = 0; c < channels; ++c)
        EXPECT_TRUE(std::equal(planes.begin() + c * pixels, planes.begin() + (c + 1) * pixels,
                               expected[size_t(c)].data))
            << pixels << " x " << channels;
      join_pixels(planes.data(), 1, pixels * channels, channels, back.data());
      EXPECT_TRUE(std::equal(back.begin(), back.end(), image.data)) << pixels << " x " << channels;
    }
}

// Weights of B, G, R in the luma, in 1/2^15, and a half.
const std::vector<int32_t> kGrey = {3735, 19235, 9798, 1 << 14};

TEST_F(Bytes, MixedPixelsMatchOpenCvGrey) {
  for (const Size& size : kSizes)
    for (const bool interleaved : {true, false}) {
      const cv::Mat image = frame(size.height, size.width, 3);
      cv::Mat expected;
      cv::cvtColor(image, expected, cv::COLOR_BGR2GRAY);
      const int64_t values = image.total() * 3;
      std::vector<uint8_t> planes(static_cast<size_t>(values)), out(static_cast<size_t>(values / 3));
      split_pixels(image.data, 1, values, 3, planes.data());
      mix_pixels(interleaved ? image.data : planes.data(), 1, values, kGrey.data(), 1, 15, interleaved,
                 out.data());
      for (size_t i = 0; i < out.size(); ++i) ASSERT_EQ(out[i], expected.data[i]);
    }
}

// Weights that need more than 16 bits, and sums that a vector's demotion to bytes may not saturate.
TEST_F(Bytes, MixedPixelsSaturateAnySum) {
  std::vector<uint8_t> x(3 * 261), out(261);
  for (size_t i = 0; i < x.size(); ++i) x[i] = static_cast<uint8_t>(i % 5);
  for (const int32_t weight : {65800, 70000, -70000, 4 << 20}) {
    const std::vector<int32_t> weights = {weight, 0, 1, 3};
    for (const bool interleaved : {true, false}) {
      mix_pixels(x.data(), 1, 3 * 261, weights.data(), 1, 1, interleaved, out.data());
      for (size_t i = 0; i < out.size(); ++i) {
        const int64_t first = interleaved ? x[3 * i] : x[i], third = interleaved ? x[3 * i + 2] : x[522 + i];
        EXPECT_EQ(out[i], std::clamp<int64_t>((weight * first + third + 3) >> 1, 0, 255)) << weight << i;
      }
    }
  }
}

// The result of a kernel for interleaved pixels; asserts that the result for planes is the same.
template <class Kernel>
cv::Mat converted(const cv::Mat& image, const Kernel& kernel) {
  const auto values = static_cast<int64_t>(image.total() * 3);
  cv::Mat out(image.size(), CV_8UC3), joined(image.size(), CV_8UC3);
  std::vector<uint8_t> planes(static_cast<size_t>(values)), made(planes.size());
  kernel(image.data, values, true, out.data);
  split_pixels(image.data, 1, values, 3, planes.data());
  kernel(planes.data(), values, false, made.data());
  join_pixels(made.data(), 1, values, 3, joined.data);
  EXPECT_EQ(cv::norm(out, joined, cv::NORM_INF), 0);
  return out;
}

cv::Mat opencv(const cv::Mat& image, int code) {
  cv::Mat made;
  cv::cvtColor(image, made, code);
  return made;
}

// The mixture by rows of weights, each with an offset.
cv::Mat mixed(const cv::Mat& image, const std::vector<int32_t>& weights, int64_t shift) {
  return converted(image, [&](const uint8_t* x, int64_t values, bool interleaved, uint8_t* out) {
    mix_pixels(x, 1, values, weights.data(), 3, shift, interleaved, out);
  });
}

TEST_F(Bytes, MixedPixelsMatchOpenCvColours) {
  const int32_t half = 1 << 13, grey = 128;
  for (const Size& size : kSizes) {
    const cv::Mat image = frame(size.height, size.width, 3);
    const auto expect = [&](const std::vector<int32_t>& weights, int64_t shift, int code) {
      EXPECT_EQ(cv::norm(mixed(image, weights, shift), opencv(image, code), cv::NORM_INF), 0) << code;
    };
    expect({1689, 1465, 739, 2048, 871, 2929, 296, 2048, 79, 488, 3892, 2048}, 12, cv::COLOR_RGB2XYZ);
    expect({13273, -6296, -2042, 2048, -3970, 7684, 170, 2048, 228, -836, 4331, 2048}, 12, cv::COLOR_XYZ2RGB);
    // A weight of more than 16 bits.
    expect({16384, 0, 18678, half - grey * 18678, 16384, -6472, -9519, half + grey * (6472 + 9519), 16384,
            33292, 0, half - grey * 33292},
           14, cv::COLOR_YUV2RGB);
    // Cr before Cb.
    expect({16384, 22987, 0, half - grey * 22987, 16384, -11698, -5636, half + grey * (11698 + 5636), 16384,
            0, 29049, half - grey * 29049},
           14, cv::COLOR_YCrCb2RGB);
  }
}

// Weights that do not fit into 16 bits, and weights that do.
TEST_F(Bytes, MixedPixelsAreTheirSums) {
  const std::vector<std::vector<int32_t>> all = {
      {40000, -33000, 12, 77, -39999, 1, 2, 3, 4, 5, 6, 7},
      {-32768, 32767, 65534, 9, 100, 200, -65536, 1 << 20, 0, 0, 1, 0},
      {255, 0, 0, 0, 0, -255, 0, 65025, 1, 1, 1, 1}};
  for (const auto& weights : all)
    for (const Size& size : kSizes)
      for (const int64_t shift : {0, 9, 16}) {
        const cv::Mat image = frame(size.height, size.width, 3), made = mixed(image, weights, shift);
        for (size_t i = 0; i < image.total(); ++i)
          for (size_t r = 0; r < 3; ++r) {
            int64_t sum = weights[4 * r + 3];
            for (size_t c = 0; c < 3; ++c) sum += int64_t{weights[4 * r + c]} * image.data[3 * i + c];
            ASSERT_EQ(made.data[3 * i + r], std::clamp<int64_t>(sum >> shift, 0, 255)) << shift;
          }
      }
}

TEST_F(Bytes, LumaAndChromaMatchOpenCv) {
  for (const Size& size : kSizes) {
    const cv::Mat image = frame(size.height, size.width, 3);
    const auto made = [&](int64_t first, int64_t second) {
      return converted(image, [=](const uint8_t* x, int64_t values, bool interleaved, uint8_t* out) {
        luma_chroma_pixels(x, 1, values, 4899, 9617, 1868, first, second, interleaved, out);
      });
    };
    EXPECT_EQ(cv::norm(made(8061, 14369), opencv(image, cv::COLOR_RGB2YUV), cv::NORM_INF), 0);
    cv::Mat swapped(image.size(), image.type());
    cv::mixChannels({made(9241, 11682)}, {swapped}, {0, 0, 1, 2, 2, 1});
    EXPECT_EQ(cv::norm(swapped, opencv(image, cv::COLOR_RGB2YCrCb), cv::NORM_INF), 0);
  }
}

// Within a level of OpenCV, which takes quotients from tables; for hues, the distance around the circle
// counts.
TEST_F(Bytes, HuesMatchOpenCv) {
  const cv::Mat image = frame(70, 333, 3);
  for (const bool lightness : {false, true}) {
    const cv::Mat out =
        converted(image, [=](const uint8_t* x, int64_t values, bool interleaved, uint8_t* to) {
          hue_pixels(x, 1, values, lightness, interleaved, to);
        });
    const cv::Mat expected = opencv(image, lightness ? cv::COLOR_RGB2HLS : cv::COLOR_RGB2HSV);
    for (size_t i = 0; i < 3 * image.total(); ++i) {
      const int difference = std::abs(out.data[i] - expected.data[i]);
      ASSERT_LE(i % 3 == 0 ? std::min(difference, 180 - difference) : difference, 1) << i;
    }
  }
}

TEST_F(Bytes, ColoursOfHuesAreTheDefinition) {
  const cv::Mat image = frame(70, 333, 3);
  for (const bool lightness : {false, true}) {
    const cv::Mat out =
        converted(image, [=](const uint8_t* x, int64_t values, bool interleaved, uint8_t* to) {
          from_hue_pixels(x, 1, values, lightness, interleaved, to);
        });
    const cv::Mat expected = opencv(image, lightness ? cv::COLOR_HLS2RGB : cv::COLOR_HSV2RGB);
    EXPECT_LE(cv::norm(out, expected, cv::NORM_INF), 1);
    for (size_t i = 0; i < image.total(); ++i) {
      const uint8_t* const p = image.data + 3 * i;
      const double second = p[1], third = p[2];
      const double chroma =
          lightness ? 2 * third * std::min(second, 255 - second) / 255 : third * second / 255;
      const double value = lightness ? second + chroma / 2 : third;
      for (size_t c = 0; c < 3; ++c) {
        const double from = std::fmod(p[0] / 30.0 + (c == 0 ? 5 : c == 1 ? 3 : 1), 6.0);
        const double level = value - chroma * std::clamp(std::min(from, 4 - from), 0.0, 1.0);
        ASSERT_LE(std::abs(out.data[3 * i + c] - level), 0.5 + 1e-9);
      }
    }
  }
}

// Tables and weights like those of L*a*b*.
struct Curve {
  std::vector<int32_t> first, middle, last;
  std::vector<int32_t> before{1777, 1541, 778, 512, 871, 2929, 296, 512, 73, 448, 3575, 512};
  std::vector<int32_t> after{0, 18931, 0, -9000, 32000, -32000, 0, 1 << 20, 0, 12800, -12800, 1 << 20};
  explicit Curve(std::mt19937& engine, int64_t lasts) {
    for (int i = 0; i < 3 * 256; ++i) first.push_back(static_cast<int32_t>(engine() % 4081));
    for (int i = 0; i <= 16320; ++i) middle.push_back(static_cast<int32_t>(engine() % 32768));
    for (int64_t i = 0; i < lasts; ++i)
      last.push_back(static_cast<int32_t>(lasts == 256 ? i : engine() % 256));
  }
  void operator()(const uint8_t* x, int64_t values, bool interleaved, uint8_t* out) const {
    curve_pixels(x, 1, values, first.data(), before.data(), middle.data(), int64_t(middle.size()),
                 after.data(), last.data(), int64_t(last.size()), 10, 21, interleaved, out);
  }
};

TEST_F(Bytes, CurvesGiveTheirEntries) {
  for (const int64_t lasts : {256, 100})
    for (const Size& size : kSizes) {
      const Curve curve(engine_, lasts);
      const cv::Mat image = frame(size.height, size.width, 3), made = converted(image, curve);
      for (size_t i = 0; i < image.total(); ++i) {
        int64_t values[3], mixed[3];
        for (size_t c = 0; c < 3; ++c) values[c] = curve.first[256 * c + image.data[3 * i + c]];
        const auto mix = [&](const std::vector<int32_t>& w, int shift, const std::vector<int32_t>& table) {
          for (size_t r = 0; r < 3; ++r)
            mixed[r] = std::clamp<int64_t>(
                (w[4 * r] * values[0] + w[4 * r + 1] * values[1] + w[4 * r + 2] * values[2] + w[4 * r + 3]) >>
                    shift,
                0, int64_t(table.size()) - 1);
          for (size_t r = 0; r < 3; ++r) values[r] = table[size_t(mixed[r])];
        };
        mix(curve.before, 10, curve.middle);
        mix(curve.after, 21, curve.last);
        for (size_t c = 0; c < 3; ++c) ASSERT_EQ(made.data[3 * i + c], values[c]) << i;
      }
    }
}

// L*u*v* by its formulas in double; OpenCV's tables are inaccurate by up to one level.
struct Luv {
  static constexpr double kMatrix[] = {432488, 374950, 189187, 223002, 749900, 75674, 20273, 124983, 996385};
  static constexpr double kInverse[] = {3.240481343200526,   -1.5371515162713185,  -0.4985363261688878,
                                        -0.9692549499965682, 1.8759900014898907,   0.04155592655829284,
                                        0.05564663913517716, -0.20404133836651123, 1.0573110696453443};
  std::vector<double> light, curve, lightness, luminance;
  std::vector<uint8_t> levels;

  Luv() {
    for (int i = 0; i < 256; ++i) {
      light.push_back(std::round(65536 * linear(i / 255.0)));
      lightness.push_back(i / 2.55);
      const double f = (lightness.back() + 16) / 116;
      luminance.push_back(lightness.back() > 8 ? f * f * f : lightness.back() / 903.2962962962963);
    }
    for (int i = 0; i <= 16384; ++i) {
      const double y = i / 16384.0;
      curve.push_back(y > 0.008856451679035631 ? 116 * std::cbrt(y) - 16 : y * 903.2962962962963);
      levels.push_back(static_cast<uint8_t>(std::lround(255 * level(y))));
    }
  }
  static double linear(double c) { return c > 0.04045 ? std::pow((c + 0.055) / 1.055, 2.4) : c / 12.92; }
  static double level(double y) { return y > 0.0031308 ? 1.055 * std::pow(y, 1 / 2.4) - 0.055 : 12.92 * y; }

  cv::Mat of(const cv::Mat& image) const {
    return converted(image, [&](const uint8_t* x, int64_t values, bool interleaved, uint8_t* out) {
      luv_pixels(x, 1, values, light.data(), kMatrix, curve.data(), int64_t(curve.size()), interleaved, out);
    });
  }
  cv::Mat back(const cv::Mat& image) const {
    return converted(image, [&](const uint8_t* x, int64_t values, bool interleaved, uint8_t* out) {
      from_luv_pixels(x, 1, values, lightness.data(), luminance.data(), kInverse, levels.data(),
                      int64_t(levels.size()), 1e-12, interleaved, out);
    });
  }
};

void expect_levels(const cv::Mat& made, size_t i, const std::array<double, 3>& exact) {
  for (size_t c = 0; c < 3; ++c)
    ASSERT_LE(std::abs(made.data[3 * i + c] - std::clamp(exact[c], 0.0, 255.0)), 1) << i << ", " << c;
}

TEST_F(Bytes, LuvMatchesItsFormulasAndOpenCv) {
  const Luv luv;
  for (const Size& size : kSizes) {
    const cv::Mat image = frame(size.height, size.width, 3), made = luv.of(image);
    EXPECT_LE(cv::norm(made, opencv(image, cv::COLOR_RGB2Luv), cv::NORM_INF), 1) << image.size();
    for (size_t i = 0; i < image.total(); ++i) {
      double xyz[3] = {};
      for (size_t c = 0; c < 9; ++c)
        xyz[c / 3] += Luv::kMatrix[c] / 1048576 * Luv::linear(image.data[3 * i + c % 3] / 255.0);
      const double y = xyz[1], sum = xyz[0] + 15 * y + 3 * xyz[2],
                   lightness = y > 0.008856451679035631 ? 116 * std::cbrt(y) - 16 : y * 903.2962962962963,
                   u = sum == 0 ? 0 : 13 * lightness * (4 * xyz[0] / sum - 0.19783940212891712),
                   v = sum == 0 ? 0 : 13 * lightness * (9 * y / sum - 0.46834220078579497);
      expect_levels(made, i, {lightness * 2.55, (u + 134) / 354 * 255, (v + 140) / 262 * 255});
    }
  }
}

TEST_F(Bytes, TheInverseOfLuvMatchesItsFormulas) {
  const Luv luv;
  for (const Size& size : kSizes) {
    const cv::Mat image = frame(size.height, size.width, 3), made = luv.back(image);
    for (size_t i = 0; i < image.total(); ++i) {
      const uint8_t* const p = image.data + 3 * i;
      const double lightness = p[0] / 2.55, u = p[1] / 255.0 * 354 - 134, v = p[2] / 255.0 * 262 - 140,
                   f = (lightness + 16) / 116, y = lightness > 8 ? f * f * f : lightness / 903.2962962962963;
      double x = 0, z = 0;
      if (lightness > 0) {
        const double u_of = u / (13 * lightness) + 0.19783940212891712,
                     v_of = v / (13 * lightness) + 0.46834220078579497;
        x = y * 9 * u_of / (4 * v_of), z = y * (12 - 3 * u_of - 20 * v_of) / (4 * v_of);
      }
      std::array<double, 3> exact;
      for (size_t c = 0; c < 3; ++c) {
        const double* const row = Luv::kInverse + 3 * c;
        exact[c] = 255 * Luv::level(std::clamp(row[0] * x + row[1] * y + row[2] * z, 0.0, 1.0));
      }
      if (lightness > 0) expect_levels(made, i, exact);
    }
  }
}

template <class T>
void expect_arranged(const std::vector<T>& x, int64_t channels, const std::vector<int32_t>& order, T fill) {
  const auto values = static_cast<int64_t>(x.size()), made = static_cast<int64_t>(order.size());
  std::vector<T> out(x.size() / static_cast<size_t>(channels) * order.size());
  arrange_pixels(x.data(), 1, values, order.data(), made, channels, double(fill), out.data());
  for (int64_t i = 0; i < values / channels; ++i)
    for (int64_t c = 0; c < made; ++c) {
      const int32_t from = order[size_t(c)];
      ASSERT_EQ(out[size_t(i * made + c)],
                from < 0 || from >= channels ? fill : x[size_t(i * channels + from)])
          << channels << " to " << made << ", pixel " << i;
    }
}

TEST_F(Bytes, PixelsAreArranged) {
  const std::vector<std::vector<int32_t>> orders = {
      {2, 1, 0}, {0, 1, 2, -1}, {2, 1, 0, 7}, {0, 0, 0}, {0, 0, 0, 9},
      {1},       {3, 3, 3, 3},  {-1, 0},      {0, 1, 2}, {4, 3, 2, 1, 0}};
  for (const int64_t channels : {1, 2, 3, 4, 5})
    for (const int64_t pixels : {1, 15, 33, 4096 + 70})
      for (const auto& order : orders) {
        std::vector<uint8_t> bytes(static_cast<size_t>(pixels * channels));
        for (auto& value : bytes) value = static_cast<uint8_t>(engine_());
        std::vector<uint16_t> words(bytes.begin(), bytes.end());
        for (auto& value : words) value = static_cast<uint16_t>(value * 257);
        std::vector<float> numbers(bytes.begin(), bytes.end());
        expect_arranged<uint8_t>(bytes, channels, order, 200);
        expect_arranged<uint16_t>(words, channels, order, 65535);
        expect_arranged<float>(numbers, channels, order, 0.5f);
      }
}

// OpenCV's factors in 1/2^20, and the luma of black.
const std::vector<int32_t> kVideo = {1220542, 1673527, -409993, -852492, 2116026, 16};

// Compares the kernel's result for n images, each with its own chroma, with the equations in 64 bits.
void expect_subsampled(const cv::Mat& luma, const cv::Mat& chroma, int n, bool swapped) {
  const int height = luma.rows / n, rows = chroma.rows / n, width = luma.cols, columns = chroma.cols;
  const size_t plane = luma.total() / size_t(n);
  std::vector<uint8_t> out(3 * luma.total()), planes(out.size()), split(out.size());
  cv::Mat parts[2];
  cv::split(chroma, parts);
  for (const bool interleaved : {false, true}) {
    std::vector<uint8_t>& made = interleaved ? out : planes;
    subsampled_pixels(luma.data, n, height, width, chroma.data, rows, 2 * columns, kVideo.data(), swapped,
                      interleaved, made.data());
    subsampled_planes(luma.data, n, height, width, parts[swapped].data, rows, columns, parts[!swapped].data,
                      kVideo.data(), interleaved, split.data());
    ASSERT_EQ(split, made) << width << " of " << columns;
  }
  for (int i = 0; i < n; ++i)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const auto* pair = chroma.ptr<uint8_t>(i * rows + y * rows / height) + 2 * (x * columns / width);
        const int64_t u = pair[swapped] - 128, v = pair[!swapped] - 128,
                      bright = std::max(luma.at<uint8_t>(i * height + y, x) - 16, 0) * int64_t{1220542};
        const int64_t sums[] = {bright + 1673527 * v, bright - 409993 * u - 852492 * v, bright + 2116026 * u};
        const size_t image = size_t(i) * 3 * plane, pixel = size_t(y * width + x);
        for (size_t c = 0; c < 3; ++c) {
          const auto level = std::clamp<int64_t>((sums[c] + (1 << 19)) >> 20, 0, 255);
          ASSERT_EQ(out[image + 3 * pixel + c], level) << width << " of " << columns << ", " << x;
          ASSERT_EQ(planes[image + c * plane + pixel], level) << width << " of " << columns << ", " << x;
        }
      }
}

TEST_F(Bytes, SubsampledPixelsAreTheirSums) {
  for (const Size& size : {Size{1, 1}, Size{2, 2}, Size{5, 7}, Size{4, 33}, Size{3, 70}, Size{2, 4096 + 71}})
    for (const bool swapped : {false, true}) {
      const cv::Mat luma = frame(2 * size.height, size.width, 1);
      const int half_rows = (size.height + 1) / 2, half_columns = (size.width + 1) / 2;
      for (const Size& part : {Size{half_rows, half_columns}, Size{size.height, half_columns},
                               Size{size.height, size.width}, Size{1, 1}, Size{2 * size.height, 3}})
        expect_subsampled(luma, frame(2 * part.height, part.width, 2), 2, swapped);
    }
}

TEST_F(Bytes, SubsampledPixelsMatchOpenCv) {
  for (const Size& size : {Size{2, 2}, Size{16, 34}, Size{36, 130}})
    for (const bool swapped : {false, true}) {
      const cv::Mat luma = frame(size.height, size.width, 1),
                    chroma = frame(size.height / 2, size.width / 2, 2);
      cv::Mat expected, out(size.height, size.width, CV_8UC3);
      cv::cvtColorTwoPlane(luma, chroma, expected, swapped ? cv::COLOR_YUV2RGB_NV21 : cv::COLOR_YUV2RGB_NV12);
      subsampled_pixels(luma.data, 1, size.height, size.width, chroma.data, size.height / 2, size.width,
                        kVideo.data(), swapped, true, out.data);
      EXPECT_EQ(cv::norm(out, expected, cv::NORM_INF), 0);
    }
}

TEST_F(Bytes, PackedPixelsMatchOpenCv) {
  for (const Size& size : {Size{1, 2}, Size{3, 4}, Size{5, 34}, Size{2, 4096 + 70}, Size{36, 130}})
    for (const bool luma_first : {false, true}) {
      constexpr int kImages = 2;
      const cv::Mat images = frame(kImages * size.height, size.width, 2);
      cv::Mat out(images.rows, size.width, CV_8UC3), planes(3 * images.rows, size.width, CV_8U);
      for (const bool interleaved : {false, true})
        packed_pixels(images.data, kImages, size.height, 2 * size.width, kVideo.data(), luma_first,
                      interleaved, (interleaved ? out : planes).data);
      const cv::Mat expected = opencv(images, luma_first ? cv::COLOR_YUV2RGB_YUYV : cv::COLOR_YUV2RGB_UYVY);
      EXPECT_EQ(cv::norm(out, expected, cv::NORM_INF), 0);
      for (int i = 0; i < kImages; ++i)
        for (int c = 0; c < 3; ++c) {
          cv::Mat channel;
          cv::extractChannel(expected.rowRange(i * size.height, (i + 1) * size.height), channel, c);
          const int top = (3 * i + c) * size.height;
          EXPECT_EQ(cv::norm(planes.rowRange(top, top + size.height), channel, cv::NORM_INF), 0);
        }
    }
}

// The factors of red, green and blue in luma, U and V, and the luma of black: BT.601's video range, in
// 1/2^20.
const std::vector<int32_t> kEncoding = {269484, 528482, 102760,  -155188, -305135,
                                        460324, 460324, -385875, -74448,  16};

// Against the equations in 64 bits, in planes and frames, also with odd sizes and rows wider than a part.
TEST_F(Bytes, Nv12PixelsAreTheirSums) {
  for (const Size& size :
       {Size{1, 1}, Size{2, 2}, Size{5, 7}, Size{4, 33}, Size{3, 70}, Size{2, 4096 + 71}}) {
    const int height = size.height, width = size.width, rows = (height + 1) / 2, columns = (width + 1) / 2;
    const size_t made = size_t(height * width + 2 * rows * columns), values = size_t(3 * height * width);
    const cv::Mat image = frame(2 * height, width, 3);
    std::vector<uint8_t> planes(2 * values), out(2 * made), of_planes(out.size());
    for (int n = 0; n < 2; ++n)
      for (int c = 0; c < 3; ++c) {
        const cv::Mat plane(height, width, CV_8U,
                            planes.data() + size_t(n) * values + size_t(c * height * width));
        cv::extractChannel(image.rowRange(n * height, (n + 1) * height), plane, c);
      }
    nv12_pixels(image.data, 2, int64_t(values), kEncoding.data(), height, true, out.data());
    nv12_pixels(planes.data(), 2, int64_t(values), kEncoding.data(), height, false, of_planes.data());
    EXPECT_EQ(out, of_planes);
    for (int n = 0; n < 2; ++n) {
      const uint8_t* const luma = out.data() + size_t(n) * made;
      const auto level = [&](int y, int x, int c) {
        return int64_t{image.at<cv::Vec3b>(n * height + std::min(y, height - 1), std::min(x, width - 1))[c]};
      };
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          int64_t sum = (33 << 19);
          for (int c = 0; c < 3; ++c) sum += kEncoding[size_t(c)] * level(y, x, c);
          ASSERT_EQ(luma[y * width + x], std::clamp<int64_t>(sum >> 20, 0, 255)) << y << ", " << x;
        }
      for (int y = 0; y < rows; ++y)
        for (int x = 0; x < 2 * columns; ++x) {
          int64_t sum = int64_t{257} << 21;
          for (int c = 0; c < 3; ++c)
            for (int k = 0; k < 4; ++k)
              sum += kEncoding[size_t(3 + 3 * (x % 2) + c)] * level(2 * y + k / 2, x / 2 * 2 + k % 2, c);
          ASSERT_EQ(luma[height * width + y * 2 * columns + x], std::clamp<int64_t>(sum >> 22, 0, 255))
              << width << ": " << y << ", " << x;
        }
    }
  }
}

TEST_F(Bytes, LumaOfNv12MatchesOpenCv) {
  const cv::Mat image = frame(36, 130, 3), expected = opencv(image, cv::COLOR_RGB2YUV_I420);
  std::vector<uint8_t> out(36 * 130 * 3 / 2);
  nv12_pixels(image.data, 1, 36 * 130 * 3, kEncoding.data(), 36, true, out.data());
  EXPECT_EQ(cv::norm(expected.rowRange(0, 36), cv::Mat(36, 130, CV_8U, out.data()), cv::NORM_INF), 0);
}

KERNEL_CALL_BENCHMARK(nv12_pixels, [] {
  return [frame = Frame()]() mutable {
    nv12_pixels(frame.x.data(), 1, 1080 * 1920 * 3, kEncoding.data(), 1080, true, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(subsampled_pixels, [] {
  return [frame = Frame()]() mutable {
    subsampled_pixels(frame.x.data(), 1, 1080, 1920, frame.x.data() + 1080 * 1920, 540, 1920, kVideo.data(),
                      false, true, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(subsampled_planes, [] {
  return [frame = Frame()]() mutable {
    const uint8_t *const luma = frame.x.data(), *const u = luma + 1080 * 1920;
    subsampled_planes(luma, 1, 1080, 1920, u, 540, 960, u + 540 * 960, kVideo.data(), true, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(packed_pixels, [] {
  return [frame = Frame()]() mutable {
    packed_pixels(frame.x.data(), 1, 1080, 3840, kVideo.data(), true, true, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(split_pixels_3, [] {
  return
      [frame = Frame()]() mutable { split_pixels(frame.x.data(), 1, 1080 * 1920 * 3, 3, frame.out.data()); };
});
KERNEL_CALL_BENCHMARK(join_pixels_3, [] {
  return
      [frame = Frame()]() mutable { join_pixels(frame.x.data(), 1, 1080 * 1920 * 3, 3, frame.out.data()); };
});
KERNEL_CALL_BENCHMARK(mix_pixels_grey, [] {
  return [frame = Frame()]() mutable {
    mix_pixels(frame.x.data(), 1, 1080 * 1920 * 3, kGrey.data(), 1, 15, true, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(mix_pixels_colours, [] {
  static const std::vector<int32_t> weights = {16384,  0,       22987, -2934144, 16384, -5636,
                                               -11698, 2226944, 16384, 29049,    0,     -3710080};
  return [frame = Frame()]() mutable {
    mix_pixels(frame.x.data(), 1, 1080 * 1920 * 3, weights.data(), 3, 14, true, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(luma_chroma_pixels, [] {
  return [frame = Frame()]() mutable {
    luma_chroma_pixels(frame.x.data(), 1, 1080 * 1920 * 3, 4899, 9617, 1868, 9241, 11682, true,
                       frame.out.data());
  };
});
template <bool kLightness>
void hue(Frame& frame) {
  hue_pixels(frame.x.data(), 1, 1080 * 1920 * 3, kLightness, true, frame.out.data());
}
template <bool kLightness>
void from_hue(Frame& frame) {
  from_hue_pixels(frame.x.data(), 1, 1080 * 1920 * 3, kLightness, true, frame.out.data());
}
KERNEL_CALL_BENCHMARK(hue_pixels, [] { return [frame = Frame()]() mutable { hue<false>(frame); }; });
KERNEL_CALL_BENCHMARK(hue_pixels_lightness, [] { return [frame = Frame()]() mutable { hue<true>(frame); }; });
KERNEL_CALL_BENCHMARK(from_hue_pixels,
                      [] { return [frame = Frame()]() mutable { from_hue<false>(frame); }; });
KERNEL_CALL_BENCHMARK(from_hue_pixels_lightness,
                      [] { return [frame = Frame()]() mutable { from_hue<true>(frame); }; });
KERNEL_CALL_BENCHMARK(curve_pixels, [] {
  std::mt19937 engine;
  return [frame = Frame(), curve = Curve(engine, 8193)]() mutable {
    curve(frame.x.data(), 1080 * 1920 * 3, true, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(luv_pixels, [] {
  return [frame = Frame(), luv = Luv()]() mutable {
    luv_pixels(frame.x.data(), 1, 1080 * 1920 * 3, luv.light.data(), Luv::kMatrix, luv.curve.data(), 16385,
               true, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(from_luv_pixels, [] {
  return [frame = Frame(), luv = Luv()]() mutable {
    from_luv_pixels(frame.x.data(), 1, 1080 * 1920 * 3, luv.lightness.data(), luv.luminance.data(),
                    Luv::kInverse, luv.levels.data(), 16385, 1e-12, true, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(arrange_pixels_3_to_3, [] {
  static const std::vector<int32_t> order = {2, 1, 0};
  return [frame = Frame()]() mutable {
    arrange_pixels(frame.x.data(), 1, 1080 * 1920 * 3, order.data(), 3, 3, 0.0, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(arrange_pixels_3_to_4, [] {
  static const std::vector<int32_t> order = {0, 1, 2, 3};
  return [frame = Frame(), out = std::vector<uint8_t>(1080 * 1920 * 4)]() mutable {
    arrange_pixels(frame.x.data(), 1, 1080 * 1920 * 3, order.data(), 4, 3, 255.0, out.data());
  };
});

}  // namespace
