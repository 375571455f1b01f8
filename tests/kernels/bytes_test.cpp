// Kernels of bytes, in planes and in frames: against OpenCV, to the bit.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "benchmarks.h"
#include "fixture.h"
#include "kernels.h"

using namespace chiasm::kernels;

namespace {

class Bytes : public ::testing::Test {
 protected:
  void SetUp() override { use_threads(3); }

  cv::Mat frame(int height, int width, int channels) {
    cv::Mat image(height, width, CV_8UC(channels));
    for (int y = 0; y < height; ++y)
      for (int i = 0; i < width * channels; ++i) image.ptr<uint8_t>(y)[i] = static_cast<uint8_t>(engine_());
    return image;
  }

  std::mt19937 engine_{7};
};

struct Size {
  int height, width;
};
constexpr Size kSizes[] = {{1, 1}, {1, 9}, {9, 1}, {5, 7}, {16, 33}, {37, 70}, {130, 21}};

int cv_border(Border border) {
  switch (border) {
    case Border::kReplicate: return cv::BORDER_REPLICATE;
    case Border::kConstant: return cv::BORDER_CONSTANT;
    default: return cv::BORDER_REFLECT_101;
  }
}

// Rounded to multiples of 1/256, each error carried on to the next tap inwards: the middle first.
std::vector<int32_t> fixed_gaussian(int radius, double sigma) {
  std::vector<double> taps;
  for (int i = -radius; i <= radius; ++i) taps.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
  const double total = std::accumulate(taps.begin(), taps.end(), 0.0);
  std::vector<int32_t> fixed(static_cast<size_t>(radius) + 1);
  double error = 0;
  int32_t sum = 0;
  for (int i = 0; i < radius; ++i) {
    const double wanted = taps[static_cast<size_t>(i)] / total * 256 + error;
    const auto tap = static_cast<int32_t>(std::lrint(wanted));
    error = wanted - tap;
    fixed[static_cast<size_t>(radius - i)] = tap;
    sum += 2 * tap;
  }
  fixed[0] = 256 - sum;
  return fixed;
}

// All taps of those from the middle to the end.
std::vector<double> full(const std::vector<int32_t>& taps) {
  std::vector<double> all(taps.rbegin(), taps.rend());
  all.insert(all.end(), taps.begin() + 1, taps.end());
  return all;
}

TEST_F(Bytes, SeparableMatchesOpenCvGaussian) {
  for (const Size& size : kSizes)
    for (const int channels : {1, 3, 4})
      for (const int radius : {0, 1, 2, 3, 10})
        for (const Border border : {Border::kReflect, Border::kReplicate, Border::kConstant}) {
          if (border == Border::kReflect && std::min(size.height, size.width) <= radius) continue;
          const double sigma = 0.3 + 0.35 * radius;
          const auto taps = fixed_gaussian(radius, sigma);
          const cv::Mat image = frame(size.height, size.width, channels);
          cv::Mat expected, out(image.size(), image.type());
          cv::sepFilter2D(image, expected, CV_64F, full(taps), full(taps), {-1, -1}, 0, cv_border(border));
          separable_bytes(image.data, 1, size.height, size.width * channels, taps.data(), 1, radius + 1,
                          taps.data(), 1, radius + 1, channels, border, out.data);
          for (int y = 0; y < size.height; ++y)
            for (int i = 0; i < size.width * channels; ++i)
              ASSERT_EQ(out.ptr<uint8_t>(y)[i], std::floor(expected.ptr<double>(y)[i] / 65536 + 0.5))
                  << size.height << " x " << size.width << " x " << channels << ", radius " << radius;
        }
}

// The mean of a window that begins (ky - 1) / 2 above and (kx - 1) / 2 left of its pixel.
cv::Mat mean_of_window(const cv::Mat& image, int ky, int kx, Border border) {
  cv::Mat padded, sums, means;
  cv::copyMakeBorder(image, padded, ky, ky, kx, kx,
                     border == Border::kCircular ? cv::BORDER_WRAP : cv_border(border));
  cv::boxFilter(padded, sums, CV_64F, {kx, ky}, {(kx - 1) / 2, (ky - 1) / 2}, false);
  // A quotient: cv::Mat's own is a product with the reciprocal, which misses halves.
  cv::divide(sums(cv::Rect(kx, ky, image.cols, image.rows)), cv::Scalar::all(ky * kx), means, 1, CV_64F);
  means.convertTo(means, CV_8U);
  return means;
}

TEST_F(Bytes, MeansOfWindowsAreRoundedOnce) {
  for (const Size& size : kSizes)
    for (const int channels : {1, 3, 4})
      for (const Size& window : {Size{1, 1}, Size{3, 3}, Size{1, 9}, Size{4, 2}, Size{14, 14}, Size{15, 15},
                                 Size{16, 16}, Size{17, 18}, Size{40, 33}, Size{3, 130}})
        for (const Border border :
             {Border::kReflect, Border::kReplicate, Border::kCircular, Border::kConstant}) {
          if (border == Border::kReflect && std::min(size.height, size.width) < 2) continue;
          const cv::Mat image = frame(size.height, size.width, channels);
          cv::Mat out(image.size(), image.type());
          box_bytes(image.data, 1, size.height, size.width * channels, window.height, window.width, channels,
                    border, out.data);
          const cv::Mat expected = mean_of_window(image, window.height, window.width, border);
          ASSERT_EQ(cv::norm(out, expected, cv::NORM_INF), 0)
              << image.size() << " x " << channels << ", window " << window.height << " x " << window.width
              << ", border " << int(border);
        }
}

// All sums that a window can have, halves too, and all quotients.
TEST_F(Bytes, MeansAreRoundedHalvesToEven) {
  for (int area = 1; area <= 300; ++area) {
    std::vector<uint8_t> x, out;
    for (int sum = 0; sum <= 255 * area; ++sum) x.push_back(0);
    out.resize(x.size());
    // A window that moves over ascending values one by one has every sum.
    for (size_t i = 0; i < x.size(); ++i)
      x[i] = static_cast<uint8_t>(i / size_t(area) + (i % size_t(area) > 0));
    const auto n = static_cast<int64_t>(x.size());
    box_bytes(x.data(), 1, 1, n, 1, area, 1, Border::kReplicate, out.data());
    for (int64_t i = area; i + area < n; i += 1) {
      int64_t sum = 0;
      for (int64_t k = i - (area - 1) / 2; k < i - (area - 1) / 2 + area; ++k) sum += x[size_t(k)];
      ASSERT_EQ(out[size_t(i)], std::nearbyint(double(sum) / area)) << area;
    }
  }
}

TEST_F(Bytes, CorrelationMatchesOpenCv) {
  for (const Size& size : kSizes)
    for (const int channels : {1, 3, 4})
      for (const Size& window : {Size{1, 1}, Size{3, 3}, Size{2, 5}, Size{7, 4}})
        for (const Border border : {Border::kReflect, Border::kReplicate, Border::kConstant}) {
          const cv::Mat image = frame(size.height, size.width, channels);
          cv::Mat taps(window.height, window.width, CV_32F), expected, out(image.size(), image.type());
          for (float& tap : cv::Mat_<float>(taps)) tap = float(int(engine_() % 201) - 100);
          taps.at<float>(0, 0) = 0;
          const float scale = 1.0f / 64;
          cv::filter2D(image, expected, CV_64F, taps, {(window.width - 1) / 2, (window.height - 1) / 2}, 0,
                       cv_border(border));
          correlate_bytes(image.data, 1, size.height, size.width * channels, taps.ptr<float>(), 1,
                          window.height, window.width, &scale, channels, border, out.data);
          cv::Mat(expected * double{scale}).convertTo(expected, CV_8U);
          EXPECT_EQ(cv::norm(out, expected, cv::NORM_INF), 0)
              << image.size() << " x " << channels << ", window " << window.height << " x " << window.width
              << ", border " << int(border);
        }
}

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

// Luma of B, G, R in 1/2^15, and a half.
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

// The image by a kernel of interleaved pixels, and of planes: both must give the same.
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

// Rows of weights, and a half.
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

// Weights that no 16 bits hold, and those that do.
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

// Within a level of OpenCV, whose quotients are of tables; of hues the distance around the circle counts.
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

// Tables and weights as L*a*b* has them.
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

TEST_F(Bytes, ResizingMatchesOpenCvsExactForm) {
  for (const Size& size : kSizes)
    for (const Size& to : {Size{1, 1}, Size{7, 5}, Size{20, 61}, Size{40, 11}, Size{64, 140}})
      for (const int channels : {1, 2, 3, 4}) {
        const cv::Mat image = frame(size.height, size.width, channels);
        cv::Mat out(to.height, to.width, image.type()), expected;
        cv::resize(image, expected, out.size(), 0, 0, cv::INTER_LINEAR_EXACT);
        resize_bytes(image.data, 1, size.height, size.width * channels, to.height, to.width, channels, false,
                     out.data);
        EXPECT_EQ(cv::norm(out, expected, cv::NORM_INF), 0)
            << image.size() << " to " << out.size() << " x " << channels;
        cv::resize(image, expected, out.size(), 0, 0, cv::INTER_NEAREST);
        resize_nearest(image.data, 1, size.height, size.width * channels, to.height, to.width, channels,
                       out.data);
        EXPECT_EQ(cv::norm(out, expected, cv::NORM_INF), 0)
            << image.size() << " to " << out.size() << " x " << channels;
      }
}

// By a loop over the definition, with taps that overshoot and numbers of pixels that are not there.
TEST_F(Bytes, ResamplingMatchesItsDefinition) {
  std::mt19937 engine(3);
  const auto draw = [&](int64_t low, int64_t high) {
    return std::uniform_int_distribution<int64_t>(low, high)(engine);
  };
  const auto sum = [](const std::vector<int64_t>& index, const std::vector<int32_t>& taps, int64_t i,
                      int64_t size, const auto& value) {
    double total = 0;
    for (int64_t k = 0; k < 5; ++k) {
      const auto at = static_cast<size_t>(5 * i + k);
      total += value(std::clamp<int64_t>(index[at], 0, size - 1)) * static_cast<double>(taps[at]);
    }
    return std::clamp(std::floor(total / 4194304.0 + 0.5), 0.0, 255.0);
  };
  for (const Size& size : kSizes)
    for (const Size& to : {Size{1, 1}, Size{7, 5}, Size{40, 61}})
      for (const int channels : {1, 2, 3, 4}) {
        const cv::Mat image = frame(size.height, size.width, channels);
        std::vector<int64_t> rows(static_cast<size_t>(5 * to.height)),
            columns(static_cast<size_t>(5 * to.width));
        std::vector<int32_t> down(rows.size()), across(columns.size());
        for (int64_t& i : rows) i = draw(-2, size.height + 1);
        for (int64_t& i : columns) i = draw(-2, size.width + 1);
        for (int32_t& tap : down) tap = static_cast<int32_t>(draw(-500000, 1500000));
        for (int32_t& tap : across) tap = static_cast<int32_t>(draw(-500000, 1500000));
        std::vector<uint8_t> out(static_cast<size_t>(to.height * to.width * channels));
        resample_bytes(image.data, 1, size.height, size.width * channels, rows.data(), to.height, 5,
                       down.data(), columns.data(), to.width, 5, across.data(), channels, out.data());
        const auto byte = [&](int64_t y, int64_t x, int c) {
          return static_cast<double>(image.data[(y * size.width + x) * channels + c]);
        };
        for (int64_t y = 0; y < to.height; ++y)
          for (int64_t x = 0; x < to.width; ++x)
            for (int c = 0; c < channels; ++c)
              ASSERT_EQ(out[static_cast<size_t>((y * to.width + x) * channels + c)],
                        sum(rows, down, y, size.height,
                            [&](int64_t row) {
                              return sum(columns, across, x, size.width,
                                         [&](int64_t column) { return byte(row, column, c); });
                            }))
                  << image.size() << " x " << channels << ", " << x << " " << y;
      }
}

TEST_F(Bytes, MirrorImagesMatchOpenCv) {
  for (const Size& size : kSizes)
    for (const int channels : {1, 2, 3, 4, 6, 20})
      for (const bool along : {false, true})
        for (const bool down : {false, true}) {
          const cv::Mat image = frame(size.height, size.width, channels);
          cv::Mat expected = image.clone(), out(image.size(), image.type());
          if (along || down) cv::flip(image, expected, along && down ? -1 : along ? 1 : 0);
          mirrored(image.data, 1, size.height, size.width * channels, channels, along, down, out.data);
          EXPECT_EQ(cv::norm(out, expected, cv::NORM_INF), 0) << image.size() << " x " << channels;
        }
  const std::vector<double> values = {1, 2, 3, 4, 5, 6, 7, 8, 9}, wanted = {7, 8, 9, 4, 5, 6, 1, 2, 3};
  std::vector<double> out(values.size());
  mirrored(values.data(), 1, 1, 9, 3, true, false, out.data());
  EXPECT_EQ(out, wanted);
}

TEST_F(Bytes, LevelsOfPyramidsMatchOpenCv) {
  for (const Size& size : kSizes)
    for (const int channels : {1, 2, 3, 4, 9}) {
      const cv::Mat image = frame(size.height, size.width, channels);
      for (const Border border : {Border::kReflect, Border::kReplicate}) {
        cv::Mat expected;
        cv::pyrDown(image, expected, {}, cv_border(border));
        cv::Mat out(expected.size(), expected.type());
        pyramid_down_bytes(image.data, 1, size.height, size.width * channels, channels, border, out.data);
        EXPECT_EQ(cv::norm(out, expected, cv::NORM_INF), 0) << image.size() << " x " << channels;
      }
      cv::Mat expected;
      cv::pyrUp(image, expected);
      cv::Mat out(expected.size(), expected.type());
      pyramid_up_bytes(image.data, 1, size.height, size.width * channels, channels, out.data);
      EXPECT_EQ(cv::norm(out, expected, cv::NORM_INF), 0) << image.size() << " x " << channels;
    }
}

// A value of `image` at a position, by the definition: 1/32 pixel, or the nearest.
uint8_t value_at(const cv::Mat& image, double x, double y, int c, bool nearest, Padding padding,
                 bool align_corners) {
  const auto place = [&](double at, int size) {
    const double scale = nearest ? 1 : 32;
    double p = std::nearbyint(std::clamp(at, -1e5, 1e5) * scale) / scale;
    if (padding == Padding::kBorder) p = std::clamp(p, 0.0, size - 1.0);
    if (padding == Padding::kReflection) {
      const double low = align_corners ? 0 : -0.5, span = align_corners ? size - 1 : size;
      if (span == 0) return 0.0;
      p = std::fmod(std::abs(p - low), 2 * span);
      p = std::clamp(std::min(p, 2 * span - p) + low, 0.0, size - 1.0);
    }
    return p;
  };
  const double px = place(x, image.cols), py = place(y, image.rows);
  const int left = int(std::floor(px)), top = int(std::floor(py));
  double sum = 0;
  for (int v = top; v < top + 2; ++v)
    for (int u = left; u < left + 2; ++u)
      if (v >= 0 && v < image.rows && u >= 0 && u < image.cols)
        sum +=
            (1 - std::abs(px - u)) * (1 - std::abs(py - v)) * image.ptr<uint8_t>(v)[u * image.channels() + c];
  return static_cast<uint8_t>(std::floor(sum + 0.5));
}

constexpr Padding kPaddings[] = {Padding::kZeros, Padding::kBorder, Padding::kReflection};
constexpr Interpolation kModes[] = {Interpolation::kNearest, Interpolation::kBilinear};

template <class At>
void expect_read(const cv::Mat& image, const cv::Mat& out, Interpolation mode, Padding padding,
                 bool align_corners, const At& at) {
  for (int v = 0; v < out.rows; ++v)
    for (int u = 0; u < out.cols; ++u)
      for (int c = 0; c < image.channels(); ++c) {
        const auto [x, y] = at(u, v);
        ASSERT_EQ(out.ptr<uint8_t>(v)[u * image.channels() + c],
                  value_at(image, x, y, c, mode == Interpolation::kNearest, padding, align_corners))
            << image.size() << " x " << image.channels() << " at " << x << ", " << y << ", padding "
            << int(padding);
      }
}

TEST_F(Bytes, RemappedPixelsMatchTheDefinitionAndOpenCv) {
  for (const Size& size : kSizes)
    for (const int channels : {1, 2, 3, 4})
      for (const Interpolation mode : kModes)
        for (const Padding padding : kPaddings)
          for (const bool align_corners : {true, false}) {
            const cv::Mat image = frame(size.height, size.width, channels);
            cv::Mat x(9, 300, CV_32F), y(9, 300, CV_32F), out(9, 300, image.type());
            cv::RNG rng(3);
            rng.fill(x, cv::RNG::UNIFORM, -0.1 * size.width - 2, 1.1 * size.width + 2);
            rng.fill(y, cv::RNG::UNIFORM, -0.1 * size.height - 2, 1.1 * size.height + 2);
            remap_bytes(image.data, 1, size.height, size.width * channels, x.ptr<float>(), 1, 9, 300,
                        y.ptr<float>(), channels, mode, padding, align_corners, out.data);
            expect_read(image, out, mode, padding, align_corners, [&](int u, int v) {
              return std::pair<double, double>{x.at<float>(v, u), y.at<float>(v, u)};
            });
            cv::Mat expected;
            cv::remap(image, expected, x, y,
                      mode == Interpolation::kNearest ? cv::INTER_NEAREST : cv::INTER_LINEAR,
                      padding == Padding::kZeros    ? cv::BORDER_CONSTANT
                      : padding == Padding::kBorder ? cv::BORDER_REPLICATE
                      : align_corners               ? cv::BORDER_REFLECT_101
                                                    : cv::BORDER_REFLECT);
            EXPECT_EQ(cv::norm(out, expected, cv::NORM_INF), 0) << image.size() << " x " << channels;
          }
}

// In 1/1024, so that every processor has the same positions.
TEST_F(Bytes, WarpedPixelsMatchTheDefinition) {
  const std::vector<double> affine = {717. / 1024, -300. / 1024, 3, 90. / 1024, 1.25, -5, 0, 0, 1},
                            perspective = {1.5, 0.25, -3, -0.125, 1.5, 2, 0.0625, 0.03125, 1};
  for (const auto& m : {affine, perspective})
    for (const Size& size : kSizes)
      for (const int channels : {1, 2, 3, 4})
        for (const Interpolation mode : kModes)
          for (const Padding padding : kPaddings) {
            const cv::Mat image = frame(size.height, size.width, channels);
            cv::Mat out(40, 280, image.type());
            warp_bytes(image.data, 1, size.height, size.width * channels, m.data(), 1, out.rows, out.cols,
                       channels, mode, padding, true, out.data);
            expect_read(image, out, mode, padding, true, [&](int u, int v) {
              const double scale = 1 / (m[6] * u + (m[7] * v + m[8]));
              return std::pair{(m[0] * u + (m[1] * v + m[2])) * scale,
                               (m[3] * u + (m[4] * v + m[5])) * scale};
            });
          }
}

// Tables of two forms, of one, and of none.
std::vector<std::vector<uint8_t>> tables(std::mt19937& engine) {
  const std::vector<std::function<int(int)>> entries = {[](int i) { return i > 127 ? 255 : 0; },
                                                        [](int i) { return i > 0 ? 0 : 200; },
                                                        [](int i) { return 255 - i; },
                                                        [](int i) { return i < 100 ? i : 255 - i; },
                                                        [](int i) { return std::min(i + 37, 255); },
                                                        [](int i) { return std::max(i - 37, 0); },
                                                        [](int i) { return i & 0xE0; },
                                                        [](int i) { return i; },
                                                        [](int i) { return i * i / 255; },
                                                        [](int i) { return i == 77 ? 1 : i; },
                                                        [&](int) { return int(engine() % 256); },
                                                        [](int) { return 9; }};
  std::vector<std::vector<uint8_t>> made;
  for (const auto& entry : entries) {
    made.emplace_back();
    for (int i = 0; i < 256; ++i) made.back().push_back(static_cast<uint8_t>(entry(i)));
  }
  return made;
}

TEST_F(Bytes, TablesGiveTheirEntries) {
  for (const auto& table : tables(engine_))
    for (const int values : {1, 31, 33, 65536 + 300}) {
      const cv::Mat x = frame(3, values, 1);
      std::vector<uint8_t> out(x.total());
      lut_bytes(table.data(), 1, x.data, 3, values, out.data());
      for (size_t i = 0; i < out.size(); ++i) ASSERT_EQ(out[i], table[x.data[i]]) << values;
    }
  const auto all = tables(engine_);
  std::vector<uint8_t> two(all[0]);
  two.insert(two.end(), all[8].begin(), all[8].end());
  const cv::Mat x = frame(4, 50, 1);
  std::vector<uint8_t> out(x.total());
  lut_bytes(two.data(), 2, x.data, 4, 50, out.data());
  for (size_t i = 0; i < out.size(); ++i) ASSERT_EQ(out[i], two[256 * (i / 100) + x.data[i]]);
}

// A frame of 1080 x 1920 x 3, and room for as much.
struct Frame {
  std::vector<uint8_t> x = std::vector<uint8_t>(1080 * 1920 * 3), out = std::vector<uint8_t>(x.size());
  Frame() {
    std::mt19937 engine(1);
    for (uint8_t& value : x) value = static_cast<uint8_t>(engine());
  }
};

template <int kRadius>
void gaussian(Frame& frame) {
  static const std::vector<int32_t> taps = fixed_gaussian(kRadius, 0.3 + 0.35 * kRadius);
  separable_bytes(frame.x.data(), 1, 1080, 1920 * 3, taps.data(), 1, kRadius + 1, taps.data(), 1, kRadius + 1,
                  3, Border::kReflect, frame.out.data());
}
KERNEL_CALL_BENCHMARK(separable_bytes_5x5,
                      [] { return [frame = Frame()]() mutable { gaussian<2>(frame); }; });
KERNEL_CALL_BENCHMARK(separable_bytes_21x21,
                      [] { return [frame = Frame()]() mutable { gaussian<10>(frame); }; });
template <int kSize>
void box(Frame& frame) {
  box_bytes(frame.x.data(), 1, 1080, 1920 * 3, kSize, kSize, 3, Border::kReflect, frame.out.data());
}
KERNEL_CALL_BENCHMARK(box_bytes_5x5, [] { return [frame = Frame()]() mutable { box<5>(frame); }; });
KERNEL_CALL_BENCHMARK(box_bytes_15x15, [] { return [frame = Frame()]() mutable { box<15>(frame); }; });
KERNEL_CALL_BENCHMARK(box_bytes_51x51, [] { return [frame = Frame()]() mutable { box<51>(frame); }; });
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
KERNEL_CALL_BENCHMARK(lut_bytes_threshold, [] {
  std::mt19937 engine;
  return [frame = Frame(), table = tables(engine)[0]]() mutable {
    lut_bytes(table.data(), 1, frame.x.data(), 1, 1080 * 1920 * 3, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(lut_bytes_square, [] {
  std::mt19937 engine;
  return [frame = Frame(), table = tables(engine)[8]]() mutable {
    lut_bytes(table.data(), 1, frame.x.data(), 1, 1080 * 1920 * 3, frame.out.data());
  };
});
template <int kHeight, int kWidth>
void resized(Frame& frame) {
  frame.out.resize(kHeight * kWidth * 3);
  resize_bytes(frame.x.data(), 1, 1080, 1920 * 3, kHeight, kWidth, 3, false, frame.out.data());
}
KERNEL_CALL_BENCHMARK(resize_bytes_half,
                      [] { return [frame = Frame()]() mutable { resized<540, 960>(frame); }; });
KERNEL_CALL_BENCHMARK(resize_bytes_up,
                      [] { return [frame = Frame()]() mutable { resized<1620, 2880>(frame); }; });
// Halves, by the nine taps of a cubic filter.
KERNEL_CALL_BENCHMARK(resample_bytes_half, [] {
  std::vector<int64_t> rows, columns;
  for (int64_t y = 0; y < 540; ++y)
    for (int64_t k = -4; k < 5; ++k) rows.push_back(2 * y + k);
  for (int64_t x = 0; x < 960; ++x)
    for (int64_t k = -4; k < 5; ++k) columns.push_back(2 * x + k);
  return [frame = Frame(), rows, columns, down = std::vector<int32_t>(rows.size(), 466034),
          across = std::vector<int32_t>(columns.size(), 466034)]() mutable {
    resample_bytes(frame.x.data(), 1, 1080, 1920 * 3, rows.data(), 540, 9, down.data(), columns.data(), 960,
                   9, across.data(), 3, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(correlate_bytes_5x5, [] {
  return [frame = Frame(), taps = std::vector<float>(25, 7.0f), scale = 1.0f / 256]() mutable {
    correlate_bytes(frame.x.data(), 1, 1080, 1920 * 3, taps.data(), 1, 5, 5, &scale, 3, Border::kReflect,
                    frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(mirrored_along, [] {
  return [frame = Frame()]() mutable {
    mirrored(frame.x.data(), 1, 1080, 1920 * 3, 3, true, false, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(pyramid_down_bytes, [] {
  return [frame = Frame()]() mutable {
    pyramid_down_bytes(frame.x.data(), 1, 1080, 1920 * 3, 3, Border::kReflect, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(pyramid_up_bytes, [] {
  return
      [frame = Frame()]() mutable { pyramid_up_bytes(frame.x.data(), 1, 540, 960 * 3, 3, frame.out.data()); };
});
template <int kStep>
void turned(Frame& frame) {
  static const double matrix[] = {0.9, -0.3, 200, 0.3, 0.9, -200, 0, 0, 1};
  warp_bytes(frame.x.data(), 1, 1080, 1920 * kStep, matrix, 1, 1080, 1920, kStep, Interpolation::kBilinear,
             Padding::kZeros, true, frame.out.data());
}
KERNEL_CALL_BENCHMARK(warp_bytes_1, [] { return [frame = Frame()]() mutable { turned<1>(frame); }; });
KERNEL_CALL_BENCHMARK(warp_bytes_3, [] { return [frame = Frame()]() mutable { turned<3>(frame); }; });
KERNEL_CALL_BENCHMARK(remap_bytes_3, [] {
  std::vector<float> x(1080 * 1920), y(x.size());
  for (size_t i = 0; i < x.size(); ++i) {
    x[i] = 0.9f * float(i % 1920) - 0.3f * float(i / 1920) + 200;
    y[i] = 0.3f * float(i % 1920) + 0.9f * float(i / 1920) - 200;
  }
  return [frame = Frame(), x, y]() mutable {
    remap_bytes(frame.x.data(), 1, 1080, 1920 * 3, x.data(), 1, 1080, 1920, y.data(), 3,
                Interpolation::kBilinear, Padding::kZeros, true, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(resize_nearest_half, [] {
  return [frame = Frame()]() mutable {
    resize_nearest(frame.x.data(), 1, 1080, 1920 * 3, 540, 960, 3, frame.out.data());
  };
});

}  // namespace
