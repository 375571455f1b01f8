// Resizing, pyramids, flips and warps of bytes, against OpenCV or their definition.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "bytes.h"

using namespace chiasm::kernels;

namespace {

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

// Against a loop over an image whose pixels are repeated so that every window has whole pixels.
TEST_F(Bytes, AreasAreMeansOfWhatTheyCover) {
  for (const int channels : {1, 2, 3, 4, 5})
    for (const Size& size : {Size{1, 1}, Size{12, 12}, Size{7, 5}, Size{6, 70}, Size{34, 4}})
      for (const Size& to : {Size{1, 1}, Size{2, 2}, Size{3, 6}, Size{6, 35}, Size{4, 4}, Size{9, 11}}) {
        const cv::Mat image = frame(2 * size.height, size.width, channels);
        std::vector<uint8_t> out(static_cast<size_t>(2 * to.height * to.width * channels));
        area_bytes(image.data, 2, size.height, size.width * channels, to.height, to.width, channels,
                   out.data());
        const int64_t area = int64_t{size.height} * size.width;
        size_t at = 0;
        for (int i = 0; i < 2; ++i)
          for (int y = 0; y < to.height; ++y)
            for (int x = 0; x < to.width; ++x)
              for (int c = 0; c < channels; ++c) {
                int64_t sum = 0;
                for (int k = y * size.height; k < (y + 1) * size.height; ++k)
                  for (int j = x * size.width; j < (x + 1) * size.width; ++j)
                    sum += image.ptr<uint8_t>(i * size.height + k / to.height)[j / to.width * channels + c];
                ASSERT_EQ(out[at++], (2 * sum + area) / (2 * area)) << image.size() << " to " << to.height;
              }
      }
}

// Parts of the image in `read`, resized by OpenCV, in outputs of 20 x 33 that are padded with 9.
TEST_F(Bytes, PlacedPixelsMatchOpenCv) {
  const cv::Rect reads[] = {{0, 0, 40, 30},
                            {5, 7, 20, 11},
                            {39, 29, 1, 1},
                            {-8, -3, 30, 20},
                            {30, 20, 25, 40}},
                 to_all[] = {
                     {0, 0, 33, 20}, {3, 4, 20, 10}, {-5, -6, 60, 50}, {32, 19, 5, 1}, {10, 2, 1, 17}};
  for (const int channels : {1, 2, 3, 4}) {
    const cv::Mat images[] = {frame(30, 40, channels), frame(30, 40, channels)};
    cv::Mat both, bordered;
    cv::vconcat(images[0], images[1], both);
    cv::copyMakeBorder(images[1], bordered, 40, 40, 40, 40, cv::BORDER_REPLICATE);
    for (const cv::Rect& read : reads)
      for (const cv::Rect& to : to_all) {
        const int64_t numbers[] = {1, 0},
                      boxes[] = {read.x, read.y, read.width, read.height, to.x, to.y, to.width, to.height,
                                 0,      0,      40,         30,          0,    0,    0,        7};
        std::vector<uint8_t> out(static_cast<size_t>(2 * 20 * 33 * channels));
        placed_bytes(both.data, 2, 30, 40 * channels, numbers, 2, boxes, 20, 33, channels, 9, out.data());
        cv::Mat part, large(20 + 200, 33 + 200, CV_8UC(channels), cv::Scalar::all(9));
        cv::resize(bordered({read.x + 40, read.y + 40, read.width, read.height}), part, to.size(), 0, 0,
                   cv::INTER_LINEAR_EXACT);
        part.copyTo(large({to.x + 100, to.y + 100, to.width, to.height}));
        const cv::Mat made(20, 33, CV_8UC(channels), out.data());
        EXPECT_EQ(cv::norm(made, large({100, 100, 33, 20}), cv::NORM_INF), 0) << read << " to " << to;
        // An empty box leaves the output empty.
        EXPECT_TRUE(std::all_of(out.begin() + 20 * 33 * channels, out.end(), [](int v) { return v == 9; }));
      }
  }
}

// Against a loop over the definition, with taps that overshoot and invalid pixel indices.
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
          flip(image.data, 1, size.height, size.width * channels, channels, along, down, out.data);
          EXPECT_EQ(cv::norm(out, expected, cv::NORM_INF), 0) << image.size() << " x " << channels;
        }
  const std::vector<double> values = {1, 2, 3, 4, 5, 6, 7, 8, 9}, wanted = {7, 8, 9, 4, 5, 6, 1, 2, 3};
  std::vector<double> out(values.size());
  flip(values.data(), 1, 1, 9, 3, true, false, out.data());
  EXPECT_EQ(out, wanted);
}

TEST_F(Bytes, TransposedImagesMatchOpenCv) {
  for (const Size& size : kSizes)
    for (const int channels : {1, 2, 3, 4, 6, 20}) {
      const cv::Mat image = frame(size.height, size.width, channels);
      cv::Mat expected, out(size.width, size.height, image.type());
      std::vector<cv::Mat> planes;
      cv::split(image, planes);
      for (cv::Mat& plane : planes) plane = plane.t();
      cv::merge(planes, expected);
      transpose_pixels(image.data, 1, size.height, size.width * channels, channels, out.data);
      EXPECT_EQ(cv::norm(out, expected, cv::NORM_INF), 0) << image.size() << " x " << channels;
    }
  const std::vector<double> values = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12},
                            wanted = {1, 4, 2, 5, 3, 6, 7, 10, 8, 11, 9, 12};  // two images
  std::vector<double> out(values.size());
  transpose_pixels(values.data(), 2, 2, 3, 1, out.data());
  EXPECT_EQ(out, wanted);
}

template <class P>
void expect_large_mirror_image(int64_t step, int64_t shift) {
  const int64_t width = 1021 * step, height = (int64_t{17} << 20) / (width * static_cast<int64_t>(sizeof(P)));
  std::vector<P> image(static_cast<size_t>(height * width)), buffer(image.size() + 16);
  std::iota(image.begin(), image.end(), P(1));
  P* const out = buffer.data() + shift;
  flip(image.data(), 1, height, width, step, true, false, out);
  for (int64_t y = 0; y < height; ++y)
    for (int64_t x = 0; x < width; ++x)
      ASSERT_EQ(out[y * width + x],
                image[static_cast<size_t>(y * width + (width / step - 1 - x / step) * step + x % step)])
          << x << " " << y;
  if (shift > 0) {
    EXPECT_EQ(out[-1], P(0));
  }
  EXPECT_EQ(out[height * width], P(0));
}

TEST(Flips, OfImagesThatAreLargerThanCaches) {
  for (const int64_t shift : {0, 1, 5}) {
    expect_large_mirror_image<float>(1, shift);
    expect_large_mirror_image<double>(1, shift);
    expect_large_mirror_image<uint16_t>(1, shift);
    expect_large_mirror_image<uint8_t>(4, shift);  // pixels that are not at a multiple of their size
    expect_large_mirror_image<uint8_t>(3, shift);
    expect_large_mirror_image<uint16_t>(4, shift);
  }
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

// Keys' kernel with a = -0.75.
double keys(double distance) {
  const double d = std::abs(distance);
  if (d >= 2) return 0;
  return d < 1 ? (1.25 * d - 2.25) * d * d + 1 : ((-0.75 * d + 3.75) * d - 6) * d + 3;
}

// Bicubic weights in 1/2^11, as in OpenCV's resizing.
TEST_F(Bytes, BicubicResizingMatchesItsDefinitionAndOpenCv) {
  const auto taps = [](int in, int out, std::vector<int64_t>& numbers, std::vector<int64_t>& weights) {
    for (int i = 0; i < out; ++i) {
      const double at = (i + 0.5) * in / out - 0.5, first = std::floor(at);
      for (int k = -1; k < 3; ++k) {
        numbers.push_back(std::clamp<int64_t>(int64_t(first) + k, 0, in - 1));
        weights.push_back(std::llround(2048 * keys(at - first - k)));
      }
    }
  };
  for (const Size& size : kSizes)
    for (const Size& to : {Size{1, 1}, Size{7, 5}, Size{40, 11}, Size{64, 140}})
      for (const int channels : {1, 2, 3, 4}) {
        const cv::Mat image = frame(size.height, size.width, channels);
        std::vector<int64_t> rows, down, columns, across;
        taps(size.height, to.height, rows, down);
        taps(size.width, to.width, columns, across);
        cv::Mat out(to.height, to.width, image.type()), expected;
        resize_cubic_bytes(image.data, 1, size.height, size.width * channels, rows.data(), to.height,
                           down.data(), columns.data(), to.width, across.data(), channels, out.data);
        cv::resize(image, expected, out.size(), 0, 0, cv::INTER_CUBIC);
        EXPECT_LE(cv::norm(out, expected, cv::NORM_INF), 1)
            << image.size() << " to " << out.size() << " x " << channels;
        for (int y = 0; y < to.height; ++y)
          for (int i = 0; i < to.width * channels; ++i) {
            int64_t sum = 1 << 21;
            for (int j = 0; j < 4; ++j)
              for (int k = 0; k < 4; ++k) {
                const auto v = size_t(4 * y + j), u = size_t(i / channels * 4 + k);
                sum += down[v] * across[u] *
                       image.ptr<uint8_t>(int(rows[v]))[columns[u] * channels + i % channels];
              }
            ASSERT_EQ(out.ptr<uint8_t>(y)[i], std::clamp<int64_t>(sum >> 22, 0, 255)) << y << ", " << i;
          }
      }
}

constexpr std::array<uint8_t, 4> kFill = {9, 250, 90, 131};  // the colour of what is outside

// The value of `image` at a position by the definition, rounded to 1/32 pixel, or to the nearest pixel.
uint8_t value_at(const cv::Mat& image, double x, double y, int c, Interpolation mode, Padding padding,
                 bool align_corners) {
  const auto limited = [](double at, double scale) {
    return std::nearbyint(std::clamp(at, -1e5, 1e5) * scale) / scale;
  };
  const auto moved = [&](double p, int size) {
    if (padding == Padding::kBorder) p = std::clamp(p, 0.0, size - 1.0);
    if (padding == Padding::kReflection) {
      const double low = align_corners ? 0 : -0.5, span = align_corners ? size - 1 : size;
      if (span == 0) return 0.0;
      p = std::fmod(std::abs(p - low), 2 * span);
      p = std::clamp(std::min(p, 2 * span - p) + low, 0.0, size - 1.0);
    }
    return p;
  };
  const auto pixel = [&](double v, double u) -> int {
    const bool inside = v >= 0 && v < image.rows && u >= 0 && u < image.cols;
    return inside ? image.ptr<uint8_t>(int(v))[int(u) * image.channels() + c] : kFill[size_t(c)];
  };
  double sum = 0;
  if (mode == Interpolation::kBicubic) {  // bicubic moves the pixels that are read, not the position
    const double px = limited(x, 32), py = limited(y, 32);
    for (double v = std::floor(py) - 1; v <= std::floor(py) + 2; ++v)
      for (double u = std::floor(px) - 1; u <= std::floor(px) + 2; ++u)
        sum += keys(px - u) * keys(py - v) * pixel(moved(v, image.rows), moved(u, image.cols));
    return static_cast<uint8_t>(std::clamp(std::floor(sum + 0.5), 0.0, 255.0));
  }
  const double scale = mode == Interpolation::kNearest ? 1 : 32, px = moved(limited(x, scale), image.cols),
               py = moved(limited(y, scale), image.rows);
  for (double v = std::floor(py); v <= std::floor(py) + 1; ++v)
    for (double u = std::floor(px); u <= std::floor(px) + 1; ++u)
      sum += (1 - std::abs(px - u)) * (1 - std::abs(py - v)) * pixel(v, u);
  return static_cast<uint8_t>(std::floor(sum + 0.5));
}

constexpr Padding kPaddings[] = {Padding::kZeros, Padding::kBorder, Padding::kReflection};
constexpr Interpolation kModes[] = {Interpolation::kNearest, Interpolation::kBilinear,
                                    Interpolation::kBicubic};

template <class At>
void expect_read(const cv::Mat& image, const cv::Mat& out, Interpolation mode, Padding padding,
                 bool align_corners, const At& at) {
  for (int v = 0; v < out.rows; ++v)
    for (int u = 0; u < out.cols; ++u)
      for (int c = 0; c < image.channels(); ++c) {
        const auto [x, y] = at(u, v);
        ASSERT_EQ(out.ptr<uint8_t>(v)[u * image.channels() + c],
                  value_at(image, x, y, c, mode, padding, align_corners))
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
                        y.ptr<float>(), channels, mode, padding, align_corners, kFill.data(), channels,
                        out.data);
            expect_read(image, out, mode, padding, align_corners, [&](int u, int v) {
              return std::pair<double, double>{x.at<float>(v, u), y.at<float>(v, u)};
            });
            cv::Mat expected;
            cv::remap(image, expected, x, y,
                      mode == Interpolation::kNearest    ? cv::INTER_NEAREST
                      : mode == Interpolation::kBilinear ? cv::INTER_LINEAR
                                                         : cv::INTER_CUBIC,
                      padding == Padding::kZeros    ? cv::BORDER_CONSTANT
                      : padding == Padding::kBorder ? cv::BORDER_REPLICATE
                      : align_corners               ? cv::BORDER_REFLECT_101
                                                    : cv::BORDER_REFLECT,
                      cv::Scalar(kFill[0], kFill[1], kFill[2], kFill[3]));
            // OpenCV's bicubic weights are rounded to 1/2^15.
            EXPECT_LE(cv::norm(out, expected, cv::NORM_INF), mode == Interpolation::kBicubic ? 1 : 0)
                << image.size() << " x " << channels;
          }
}

TEST_F(Bytes, WhatIsNoNumberReadsNothing) {
  const cv::Mat image = frame(8, 30, 3);
  const double none = std::nan("");
  const std::vector<double> x = {none, 3, none}, y = {3, none, none};
  for (const Padding padding : kPaddings) {
    std::vector<uint8_t> out(9, 7);
    remap_bytes(image.data, 1, 8, 90, x.data(), 1, 1, 3, y.data(), 3, Interpolation::kBicubic, padding, true,
                kFill.data(), 3, out.data());
    for (size_t i = 0; i < 9; ++i) EXPECT_EQ(out[i], kFill[i % 3]);
  }
}

// Matrices in multiples of 1/1024, so that every CPU has the same positions.
TEST_F(Bytes, WarpedPixelsMatchTheDefinition) {
  const std::vector<double> affine = {717. / 1024, -300. / 1024, 3, 90. / 1024, 1.25, -5, 0, 0, 1},
                            perspective = {1.5, 0.25, -3, -0.125, 1.5, 2, 0.0625, 0.03125, 1},
                            moved = {1, 0, -3, 0, 1, 5, 0, 0, 1}, away = {1, 0, 9e4, 0, 1, -9e4, 0, 0, 1};
  for (const auto& m : {affine, perspective, moved, away})
    for (const Size& size : kSizes)
      for (const int channels : {1, 2, 3, 4})
        for (const Interpolation mode : kModes)
          for (const Padding padding : kPaddings) {
            const cv::Mat image = frame(size.height, size.width, channels);
            cv::Mat out(40, 280, image.type());
            warp_bytes(image.data, 1, size.height, size.width * channels, m.data(), 1, out.rows, out.cols,
                       channels, mode, padding, true, kFill.data(), channels, out.data);
            expect_read(image, out, mode, padding, true, [&](int u, int v) {
              const double scale = 1 / (m[6] * u + (m[7] * v + m[8]));
              return std::pair{(m[0] * u + (m[1] * v + m[2])) * scale,
                               (m[3] * u + (m[4] * v + m[5])) * scale};
            });
          }
}

template <int kHeight, int kWidth>
void resized(Frame& frame) {
  frame.out.resize(kHeight * kWidth * 3);
  resize_bytes(frame.x.data(), 1, 1080, 1920 * 3, kHeight, kWidth, 3, false, frame.out.data());
}
KERNEL_CALL_BENCHMARK(resize_bytes_half,
                      [] { return [frame = Frame()]() mutable { resized<540, 960>(frame); }; });
KERNEL_CALL_BENCHMARK(resize_bytes_up,
                      [] { return [frame = Frame()]() mutable { resized<1620, 2880>(frame); }; });
KERNEL_CALL_BENCHMARK(area_bytes_half, [] {
  return [frame = Frame()]() mutable {
    area_bytes(frame.x.data(), 1, 1080, 1920 * 3, 540, 960, 3, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(area_bytes, [] {
  return [frame = Frame()]() mutable {
    area_bytes(frame.x.data(), 1, 1080, 1920 * 3, 417, 733, 3, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(placed_bytes, [] {
  return [frame = Frame()]() mutable {
    const int64_t first = 0, box[] = {0, 0, 1920, 1080, 0, 140, 640, 360};
    placed_bytes(frame.x.data(), 1, 1080, 1920 * 3, &first, 1, box, 640, 640, 3, 114, frame.out.data());
  };
});
// Reduction by a half, with the nine taps of a cubic filter.
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
KERNEL_CALL_BENCHMARK(flip_along, [] {
  return [frame = Frame()]() mutable {
    flip(frame.x.data(), 1, 1080, 1920 * 3, 3, true, false, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(transpose_pixels_3, [] {
  return [frame = Frame()]() mutable {
    transpose_pixels(frame.x.data(), 1, 1080, 1920 * 3, 3, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(transpose_pixels_1, [] {
  return [frame = Frame()]() mutable {
    transpose_pixels(frame.x.data(), 1, 1080 * 3, 1920, 1, frame.out.data());
  };
});
KERNEL_BENCHMARK(flip_along_floats, [](const float* x, Planes p, float* out) {
  flip(x, p.count, p.height, p.width, 1, true, false, out);
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
template <int kStep, Interpolation kMode>
void turned(Frame& frame) {
  static const double matrix[] = {0.9, -0.3, 200, 0.3, 0.9, -200, 0, 0, 1};
  warp_bytes(frame.x.data(), 1, 1080, 1920 * kStep, matrix, 1, 1080, 1920, kStep, kMode, Padding::kZeros,
             true, kFill.data(), kStep, frame.out.data());
}
KERNEL_CALL_BENCHMARK(warp_bytes_1, [] {
  return [frame = Frame()]() mutable { turned<1, Interpolation::kBilinear>(frame); };
});
KERNEL_CALL_BENCHMARK(warp_bytes_3, [] {
  return [frame = Frame()]() mutable { turned<3, Interpolation::kBilinear>(frame); };
});
KERNEL_CALL_BENCHMARK(warp_bytes_cubic_1, [] {
  return [frame = Frame()]() mutable { turned<1, Interpolation::kBicubic>(frame); };
});
KERNEL_CALL_BENCHMARK(warp_bytes_cubic_3, [] {
  return [frame = Frame()]() mutable { turned<3, Interpolation::kBicubic>(frame); };
});
template <int kStep, int kHeight, int kWidth>
auto resized_cubic() {
  std::vector<int64_t> rows, columns, weights;
  for (int64_t y = 0; y < kHeight; ++y)
    for (int64_t k = -1; k < 3; ++k) rows.push_back(std::clamp<int64_t>(y * 1080 / kHeight + k, 0, 1079));
  for (int64_t x = 0; x < kWidth; ++x)
    for (int64_t k = -1; k < 3; ++k) columns.push_back(std::clamp<int64_t>(x * 1920 / kWidth + k, 0, 1919));
  for (int64_t i = 0; i < std::max(kHeight, kWidth); ++i)
    for (const int64_t weight : {-192, 1216, 1216, -192}) weights.push_back(weight);
  return
      [frame = Frame(), rows, columns, weights, out = std::vector<uint8_t>(kHeight * kWidth * 3)]() mutable {
        resize_cubic_bytes(frame.x.data(), 3 / kStep, 1080, 1920 * kStep, rows.data(), kHeight,
                           weights.data(), columns.data(), kWidth, weights.data(), kStep, out.data());
      };
}
KERNEL_CALL_BENCHMARK(resize_cubic_bytes_1, [] { return resized_cubic<1, 810, 1440>(); });
KERNEL_CALL_BENCHMARK(resize_cubic_bytes_3, [] { return resized_cubic<3, 810, 1440>(); });
KERNEL_CALL_BENCHMARK(resize_cubic_bytes_up, [] { return resized_cubic<3, 1620, 2880>(); });
KERNEL_CALL_BENCHMARK(remap_bytes_3, [] {
  std::vector<float> x(1080 * 1920), y(x.size());
  for (size_t i = 0; i < x.size(); ++i) {
    x[i] = 0.9f * float(i % 1920) - 0.3f * float(i / 1920) + 200;
    y[i] = 0.3f * float(i % 1920) + 0.9f * float(i / 1920) - 200;
  }
  return [frame = Frame(), x, y]() mutable {
    remap_bytes(frame.x.data(), 1, 1080, 1920 * 3, x.data(), 1, 1080, 1920, y.data(), 3,
                Interpolation::kBilinear, Padding::kZeros, true, kFill.data(), 3, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(resize_nearest_half, [] {
  return [frame = Frame()]() mutable {
    resize_nearest(frame.x.data(), 1, 1080, 1920 * 3, 540, 960, 3, frame.out.data());
  };
});

}  // namespace
