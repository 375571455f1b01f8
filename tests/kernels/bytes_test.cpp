// Filters and tables of bytes, in planes and in frames, against OpenCV, bit for bit.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "bytes.h"

using namespace chiasm::kernels;

namespace {

// The taps of a Gaussian in 1/256, the middle one first. They are rounded from the outermost one inwards, and
// each rounding error is added to the next tap.
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

// All taps of a symmetric window, given those from the middle on.
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
  // A true division: cv::Mat's operator multiplies by the reciprocal, which misses halves.
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

// The window as float64 taps: 1, and 1 minus their number in the middle.
TEST_F(Bytes, LaplaciansAreExact) {
  for (const Size& size : kSizes)
    for (const int channels : {1, 3, 4})
      for (const Size& window :
           {Size{1, 1}, Size{3, 3}, Size{5, 3}, Size{1, 9}, Size{9, 13}, Size{11, 11}, Size{129, 1}})
        for (const Border border :
             {Border::kReflect, Border::kReplicate, Border::kCircular, Border::kConstant}) {
          if (border == Border::kReflect && std::min(size.height, size.width) < 2) continue;
          cv::Mat image = frame(size.height, size.width, channels), padded, expected, out;
          image(cv::Rect(0, 0, 1, 1)) = cv::Scalar::all(255);
          const auto h = static_cast<int>(window.height), w = static_cast<int>(window.width);
          cv::Mat taps = cv::Mat::ones(h, w, CV_64F);
          taps.at<double>(h / 2, w / 2) = 1 - h * w;
          cv::copyMakeBorder(image, padded, h, h, w, w,
                             border == Border::kCircular ? cv::BORDER_WRAP : cv_border(border));
          padded.convertTo(padded, CV_64F);
          cv::filter2D(padded, expected, CV_64F, taps);
          expected(cv::Rect(w, h, image.cols, image.rows)).convertTo(expected, CV_16S);
          out.create(image.size(), CV_16SC(channels));
          laplacian_bytes(image.data, 1, size.height, size.width * channels, window.height, window.width,
                          channels, border, out.ptr<int16_t>());
          ASSERT_EQ(cv::norm(out, expected, cv::NORM_INF), 0)
              << image.size() << " x " << channels << ", window " << window.height << " x " << window.width
              << ", border " << int(border);
        }
}

// Tests all sums that a window can have, including halves, and all quotients.
TEST_F(Bytes, MeansAreRoundedHalvesToEven) {
  for (int area = 1; area <= 300; ++area) {
    std::vector<uint8_t> x, out;
    for (int sum = 0; sum <= 255 * area; ++sum) x.push_back(0);
    out.resize(x.size());
    // A window that moves over ascending values takes every sum.
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

// Tables of two kinds, of one, and of neither.
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

TEST_F(Bytes, LutPixelsAreTheEntries) {
  std::vector<uint8_t> table;
  for (const size_t which : {0, 3, 8}) {
    const auto entries = tables(engine_)[which];
    table.insert(table.end(), entries.begin(), entries.end());
  }
  for (const int count : {1, 2, 33, 16384, 3 * 16384 + 1}) {
    const cv::Mat x = frame(1, count, 1);
    std::vector<uint8_t> out(3 * x.total());
    lut_pixels(table.data(), x.data, count, out.data());
    for (size_t i = 0; i < out.size(); ++i) ASSERT_EQ(out[i], table[256 * (i % 3) + x.data[i / 3]]) << count;
  }
}

// Against the definition in double, with tables like those of falloffs.
TEST_F(Bytes, BilateralBytesMatchTheDefinition) {
  constexpr int ky = 3, kx = 5, channels = 2;
  for (const Size& size : kSizes)
    for (const Border border : {Border::kReflect, Border::kReplicate, Border::kConstant})
      for (const bool squares : {true, false})
        for (const int depth : {1, 3}) {
          const int entries = depth * (squares ? 65025 : 255) + 1, area = size.height * size.width;
          const cv::Mat x = frame(2 * channels * size.height, size.width, 1),
                        guide = frame(2 * depth * size.height, size.width, 1);
          std::vector<double> space_weights(2 * ky * kx), range_weights(size_t(2 * entries));
          for (int k = 0; k < 2 * ky * kx; ++k) {
            const int y = k / kx % ky - ky / 2, column = k % kx - kx / 2;
            space_weights[size_t(k)] = std::round(65536 * std::exp(-0.2 * (y * y + column * column)));
          }
          for (int k = 0; k < 2 * entries; ++k) {
            const double apart = k % entries;
            range_weights[size_t(k)] =
                std::round(65536 * std::exp(-1e-4 * (squares ? apart : apart * apart)));
          }
          std::vector<uint8_t> out(x.total());
          bilateral_bytes(x.data, {2, channels, size.height, size.width}, guide.data, 2, depth,
                          space_weights.data(), 2, ky, kx, range_weights.data(), 2, entries, border, squares,
                          out.data());
          const auto at = [&](const cv::Mat& image, int plane, int r, int c) {
            const int v = cv::borderInterpolate(r, size.height, cv_border(border)),
                      u = cv::borderInterpolate(c, size.width, cv_border(border));
            return v < 0 || u < 0 ? 0 : int(image.at<uint8_t>(plane * size.height + v, u));
          };
          for (int n = 0; n < 2; ++n)
            for (int r = 0; r < size.height; ++r)
              for (int c = 0; c < size.width; ++c) {
                double total = 0, sums[channels] = {};
                for (int k = 0; k < ky * kx; ++k) {
                  const int v = r + k / kx - ky / 2, u = c + k % kx - kx / 2;
                  int distance = 0;
                  for (int d = 0; d < depth; ++d) {
                    const int apart =
                        std::abs(at(guide, n * depth + d, v, u) - at(guide, n * depth + d, r, c));
                    distance += squares ? apart * apart : apart;
                  }
                  const double weight = space_weights[size_t(k)] * range_weights[size_t(distance)];
                  total += weight;
                  for (int i = 0; i < channels; ++i) sums[i] += weight * at(x, n * channels + i, v, u);
                }
                for (int i = 0; i < channels; ++i)
                  ASSERT_EQ(out[size_t((n * channels + i) * area + r * size.width + c)],
                            std::floor((2 * sums[i] + total) / (2 * total)))
                      << size.height << "x" << size.width << ", " << r << ", " << c;
              }
        }
}

TEST_F(Bytes, WithoutAWeightThereIsNoMean) {
  const cv::Mat x = frame(5, 37, 1);
  const double none[256] = {};
  std::vector<uint8_t> out(x.total(), 9);
  bilateral_bytes(x.data, {1, 1, 5, 37}, x.data, 1, 1, none, 1, 3, 3, none, 1, 256, Border::kReflect, false,
                  out.data());
  EXPECT_EQ(out, std::vector<uint8_t>(x.total(), 0));
}

TEST_F(Bytes, IntegralBytesMatchOpenCv) {
  std::vector<Size> sizes(std::begin(kSizes), std::end(kSizes));
  sizes.push_back({200, 37});  // strips of rows
  for (const Size& size : sizes)
    for (const int channels : {1, 2, 3, 4}) {
      const cv::Mat image = frame(2 * size.height, size.width, channels);
      std::vector<int32_t> out(image.total() * size_t(channels));
      for (const int threads : {1, 3}) {
        use_threads(threads);
        std::fill(out.begin(), out.end(), -1);
        integral_bytes(image.data, 2, size.height, size.width * channels, channels, out.data());
        for (int n = 0; n < 2; ++n) {
          cv::Mat sums;
          cv::integral(image.rowRange(n * size.height, (n + 1) * size.height), sums, CV_32S);
          const cv::Mat made(size.height, size.width, CV_32SC(channels),
                             out.data() + n * size.height * size.width * channels);
          EXPECT_EQ(cv::norm(sums(cv::Rect(1, 1, size.width, size.height)), made, cv::NORM_INF), 0)
              << image.size() << " x " << channels;
        }
      }
    }
  use_threads(1);
}

TEST_F(Bytes, IntegralBytesEndAtTheLargestNumber) {
  for (const Size& size : {Size{2, 8421600}, Size{3000, 3000}})
    for (const int channels : {1, 2, 3}) {
      const std::vector<uint8_t> x(size_t(size.height) * size_t(size.width * channels), 255);
      std::vector<int32_t> out(x.size());
      use_threads(channels);
      integral_bytes(x.data(), 1, size.height, size.width * channels, channels, out.data());
      for (int64_t y = 0; y < size.height; ++y)
        for (int64_t k = 0; k < size.width; k += k + 100 < size.width ? 99 : 1)
          for (int c = 0; c < channels; ++c)
            ASSERT_EQ(out[size_t((y * size.width + k) * channels + c)],
                      std::min<int64_t>(255 * (y + 1) * (k + 1), INT32_MAX));
    }
  use_threads(1);
}

// The reference mirrors the image at its borders first, because OpenCV does not.
template <class U>
void expect_demosaic(cv::Mat image) {
  const int codes[2][2] = {{cv::COLOR_BayerBG2RGB, cv::COLOR_BayerGB2RGB},
                           {cv::COLOR_BayerGR2RGB, cv::COLOR_BayerRG2RGB}};
  cv::Mat padded;
  cv::copyMakeBorder(image, padded, 2, 2, 2, 2, cv::BORDER_REFLECT_101);
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 2; ++column) {
      cv::Mat expected, out(image.size(), CV_MAKETYPE(image.depth(), 3)), planes[3];
      cv::cvtColor(padded, expected, codes[row][column]);
      expected = expected(cv::Rect(2, 2, image.cols, image.rows));
      demosaic(image.ptr<U>(), 1, image.rows, image.cols, row, column, true, out.ptr<U>());
      EXPECT_EQ(cv::norm(out, expected, cv::NORM_INF), 0) << image.size() << " " << row << column;
      cv::Mat joined(3 * image.rows, image.cols, image.type());
      demosaic(image.ptr<U>(), 1, image.rows, image.cols, row, column, false, joined.ptr<U>());
      for (int c = 0; c < 3; ++c) {
        cv::extractChannel(expected, planes[0], c);
        EXPECT_EQ(cv::norm(planes[0], joined.rowRange(c * image.rows, (c + 1) * image.rows), cv::NORM_INF),
                  0);
      }
    }
}

TEST_F(Bytes, DemosaicedPixelsMatchOpenCv) {
  for (const Size& size : {Size{3, 3}, Size{5, 7}, Size{16, 33}, Size{37, 70}, Size{130, 21}, Size{4, 257}}) {
    expect_demosaic<uint8_t>(frame(size.height, size.width, 1));
    const cv::Mat bytes = frame(size.height, 2 * size.width, 1);
    expect_demosaic<uint16_t>(cv::Mat(size.height, size.width, CV_16U, bytes.data).clone());
  }
}

// Tests axes with only two pixels.
TEST_F(Bytes, TheLeastBayerImageIsMirrored) {
  const std::vector<uint8_t> x = {10, 20, 30, 41}, green = {25, 20, 30, 25};
  std::vector<uint8_t> out(12);
  demosaic(x.data(), 1, 2, 2, 0, 0, false, out.data());
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(out[i], 10);
    EXPECT_EQ(out[4 + i], green[i]);
    EXPECT_EQ(out[8 + i], 41);
  }
}

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
KERNEL_CALL_BENCHMARK(laplacian_bytes_3x3, [] {
  return [frame = Frame(), out = std::vector<int16_t>(size_t{1080} * 1920 * 3)]() mutable {
    laplacian_bytes(frame.x.data(), 1, 1080, 1920 * 3, 3, 3, 3, Border::kReflect, out.data());
  };
});
KERNEL_CALL_BENCHMARK(box_bytes_5x5, [] { return [frame = Frame()]() mutable { box<5>(frame); }; });
KERNEL_CALL_BENCHMARK(box_bytes_15x15, [] { return [frame = Frame()]() mutable { box<15>(frame); }; });
KERNEL_CALL_BENCHMARK(box_bytes_51x51, [] { return [frame = Frame()]() mutable { box<51>(frame); }; });
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
KERNEL_CALL_BENCHMARK(lut_pixels, [] {
  return [frame = Frame(), table = std::vector<uint8_t>(768, 7)]() mutable {
    lut_pixels(table.data(), frame.x.data(), 1080 * 1920, frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(correlate_bytes_5x5, [] {
  return [frame = Frame(), taps = std::vector<float>(25, 7.0f), scale = 1.0f / 256]() mutable {
    correlate_bytes(frame.x.data(), 1, 1080, 1920 * 3, taps.data(), 1, 5, 5, &scale, 3, Border::kReflect,
                    frame.out.data());
  };
});
KERNEL_CALL_BENCHMARK(bilateral_bytes_5x5, [] {
  std::vector<double> space_weights(25), range_weights(766);
  for (size_t k = 0; k < 766; ++k) range_weights[k] = std::round(65536 * std::exp(-1e-3 * double(k * k)));
  for (size_t k = 0; k < 25; ++k) space_weights[k] = k == 12 ? 65536 : 30000;
  return [frame = Frame(), space_weights, range_weights]() mutable {
    bilateral_bytes(frame.x.data(), {1, 3, 1080, 1920}, frame.x.data(), 1, 3, space_weights.data(), 1, 5, 5,
                    range_weights.data(), 1, 766, Border::kReflect, false, frame.out.data());
  };
});
template <int kStep>
void integral(Frame& frame, std::vector<int32_t>& out) {
  integral_bytes(frame.x.data(), 3 / kStep, 1080, 1920 * kStep, kStep, out.data());
}
KERNEL_CALL_BENCHMARK(integral_bytes_1, [] {
  return
      [frame = Frame(), out = std::vector<int32_t>(1080 * 1920 * 3)]() mutable { integral<1>(frame, out); };
});
KERNEL_CALL_BENCHMARK(integral_bytes_3, [] {
  return
      [frame = Frame(), out = std::vector<int32_t>(1080 * 1920 * 3)]() mutable { integral<3>(frame, out); };
});
KERNEL_CALL_BENCHMARK(demosaic, [] {
  return
      [frame = Frame()]() mutable { demosaic(frame.x.data(), 1, 1080, 1920, 0, 0, true, frame.out.data()); };
});
KERNEL_CALL_BENCHMARK(demosaic_planes, [] {
  return
      [frame = Frame()]() mutable { demosaic(frame.x.data(), 1, 1080, 1920, 0, 0, false, frame.out.data()); };
});
KERNEL_CALL_BENCHMARK(demosaic_16, [] {
  return
      [x = std::vector<uint16_t>(1080 * 1920, 777), out = std::vector<uint16_t>(1080 * 1920 * 3)]() mutable {
        demosaic(x.data(), 1, 1080, 1920, 0, 0, true, out.data());
      };
});

}  // namespace
