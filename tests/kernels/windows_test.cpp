// Extrema and ranks over windows, for pixels of every type, in planes and interleaved, against OpenCV or the
// definition in plain loops.
#include <cmath>
#include <limits>
#include <map>
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
constexpr double kAbsent = 1e4;

// Images whose pixels have `step` values each.
struct Size {
  int64_t count, height, width, step;
  int64_t values() const { return count * height * width * step; }
  int64_t length() const { return width * step; }
};
std::ostream& operator<<(std::ostream& stream, const Size& s) {
  return stream << s.count << " x " << s.height << " x " << s.width << " x " << s.step;
}
// A pixel, less than a vector, odd sizes, more than a tile's rows, and more than a strip's columns.
constexpr Size kSizes[] = {{1, 1, 1, 1},  {1, 1, 2, 3},  {2, 3, 5, 1},   {2, 3, 5, 4},
                           {3, 9, 17, 1}, {1, 8, 11, 3}, {1, 70, 33, 1}, {2, 135, 13, 3}};
constexpr Size kWide[] = {{1, 3, 30011, 1}, {1, 3, 9001, 4}, {1, 7, 65, 3}};

template <class P>
class Windows : public ::testing::Test {
 protected:
  void SetUp() override { use_threads(3); }

  // Random values over the whole range of an integer type, or from 0 to 1.
  std::vector<P> random(int64_t n) {
    std::vector<P> values(static_cast<size_t>(n));
    for (P& v : values) {
      if constexpr (std::is_floating_point_v<P>)
        v = std::uniform_real_distribution<P>(0, 1)(engine_);
      else
        v = static_cast<P>(engine_());
    }
    return values;
  }

  // The image's value, or `value` outside the image if the border is constant.
  static P at(const std::vector<P>& x, const Size& s, Border border, P value, int64_t image, int64_t row,
              int64_t pixel, int64_t channel) {
    const int v = cv::borderInterpolate(int(row), int(s.height), kOpenCvBorders[int(border)]);
    const int u = cv::borderInterpolate(int(pixel), int(s.width), kOpenCvBorders[int(border)]);
    return v < 0 || u < 0 ? value : x[size_t(((image * s.height + v) * s.width + u) * s.step + channel)];
  }

  // Compares `actual` with expected(image, row, pixel, channel); in wide images, only a part.
  template <class Expected>
  static void expect_all(const std::vector<P>& actual, const Size& s, const Expected& expected) {
    for (int64_t i = 0; i < s.count; ++i)
      for (int64_t r = 0; r < s.height; ++r)
        for (int64_t c = 0; c<s.width; c += s.width> 100 ? 17 : 1)
          for (int64_t k = 0; k < s.step; ++k)
            ASSERT_EQ(actual[size_t(((i * s.height + r) * s.width + c) * s.step + k)], expected(i, r, c, k))
                << s << " at " << i << ", " << r << ", " << c << ", " << k;
  }

  // Compares `actual` with the value of a rank in each window of ky x kx.
  static void expect_ranks(const std::vector<P>& x, const std::vector<P>& actual, const Size& s, int64_t ky,
                           int64_t kx, int64_t rank, Border border) {
    std::vector<P> window(size_t(ky * kx));
    expect_all(actual, s, [&](int64_t i, int64_t r, int64_t c, int64_t k) {
      for (int64_t t = 0; t < ky * kx; ++t)
        window[size_t(t)] = at(x, s, border, 0, i, r + t / kx - ky / 2, c + t % kx - kx / 2, k);
      std::nth_element(window.begin(), window.begin() + rank, window.end());
      return window[size_t(rank)];
    });
  }

  std::mt19937 engine_{11};
};

using Types = ::testing::Types<uint8_t, int16_t, uint16_t, float, double>;
TYPED_TEST_SUITE(Windows, Types);

template <class P>
cv::Mat image_of(const std::vector<P>& values, const Size& s, int64_t i) {
  return cv::Mat(int(s.height), int(s.width), CV_MAKETYPE(cv::DataType<P>::depth, int(s.step)),
                 const_cast<P*>(values.data() + i * s.height * s.length()));
}

TYPED_TEST(Windows, MinmaxFilterMatchesOpenCv) {
  using P = TypeParam;
  const P value = std::is_integral_v<P> ? P(77) : P(0.5);
  const auto check = [&](const Size& s, int64_t ky, int64_t kx) {
    const auto x = this->random(s.values());
    std::vector<P> out(x.size());
    for (int b = 0; b < 4; ++b)
      for (const bool largest : {true, false}) {
        minmax_filter(x.data(), s.count, s.height, s.length(), s.step, ky, kx, kBorders[b], value, largest,
                      out.data());
        for (int64_t i = 0; i < s.count; ++i) {
          cv::Mat padded, result;
          const int ry = int(ky / 2), rx = int(kx / 2);
          cv::copyMakeBorder(image_of(x, s, i), padded, ry, ry, rx, rx, kOpenCvBorders[b],
                             cv::Scalar::all(double(value)));
          (largest ? cv::dilate : cv::erode)(padded, result, cv::Mat::ones(int(ky), int(kx), CV_8U), {-1, -1},
                                             1, cv::BORDER_REPLICATE, cv::Scalar());
          const cv::Mat expected = result(cv::Rect(rx, ry, int(s.width), int(s.height)));
          ASSERT_EQ(cv::norm(expected, image_of(out, s, i), cv::NORM_INF), 0)
              << s << ", " << ky << " x " << kx << ", border " << b;
        }
      }
  };
  for (const Size& s : kSizes)
    for (const int64_t size : {1, 3, 5, 7, 9, 31}) check(s, size, size), check(s, size, 3), check(s, 1, size);
  for (const Size& s : kWide) check(s, 3, 31), check(s, 9, 5);
}

// A huge window needs no more memory than one that reaches from each pixel over the whole image.
TYPED_TEST(Windows, MinmaxFilterOfAnyWindow) {
  using T = TypeParam;
  const std::vector<T> x = {3, 1, 4, 1, 5, 9, 2, 6, 5, 3, 5, 8};
  std::vector<T> out(x.size());
  for (const Border border : kBorders)
    for (const int64_t step : {1, 2}) {
      minmax_filter(x.data(), 1, 2, 6, step, INT32_MAX, INT32_MAX, border, 7.0, true, out.data());
      for (size_t i = 0; i < out.size(); ++i) {
        const T expected = step == 1                                   ? T(9)
                           : border == Border::kConstant && i % 2 == 0 ? T(7)
                                                                       : T(i % 2 ? 9 : 5);
        EXPECT_EQ(out[i], expected) << i;
      }
    }
}

TYPED_TEST(Windows, MorphologyMatchesItsDefinition) {
  using P = TypeParam;
  struct Element {
    int64_t kh, kw, row, column;
    std::vector<double> there;  // 1 where the window has a pixel
  };
  const Element elements[] = {
      {3, 4, 1, 2, {1, 0, 1, 1, 1, 1, 1, 0, 1, 1, 1, 1}},                          // few
      {3, 3, 1, 1, {0, 1, 0, 1, 0, 1, 0, 1, 0}},                                   // not its origin
      {4, 5, 0, 3, {0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0}},  // a box beside the origin
      {9, 2, 8, 0, std::vector<double>(18, 1)},
      {5, 7, 2, 3, {0, 0, 1, 1, 1, 0, 0, 0, 1, 1, 1, 1, 1, 0, 1, 1, 1, 1,
                    1, 1, 1, 0, 1, 1, 1, 1, 1, 0, 0, 0, 1, 1, 1, 0, 0}},  // a disk
      {4, 6, 3, 0, {1, 1, 0, 1, 1, 1, 1, 1, 1, 1, 0, 1,
                    0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1}},  // rows of chords
      {2, 2, 0, 1, {0, 0, 0, 0}}};                         // nothing
  const P value = std::is_integral_v<P> ? P(77) : P(0.25);
  const auto check = [&](const Size& s, const Element& e, Border border, bool largest, bool flat) {
    const auto x = this->random(s.values());
    std::vector<double> heights(e.there.size());
    for (size_t k = 0; k < heights.size(); ++k)
      heights[k] = e.there[k] == 0 ? -kAbsent : flat ? 0 : double(float(k)) * 0.0625;
    std::vector<P> out(x.size());
    morphology(x.data(), s.count, s.height, s.length(), s.step, heights.data(), e.kh, e.kw, e.row, e.column,
               border, value, kAbsent, largest, out.data());
    this->expect_all(out, s, [&](int64_t i, int64_t r, int64_t c, int64_t k) {
      using Limits = std::numeric_limits<P>;
      P best = std::is_integral_v<P> ? (largest ? Limits::lowest() : Limits::max())
                                     : P(largest ? -INFINITY : INFINITY);
      for (int64_t t = 0; t < e.kh * e.kw; ++t) {
        if (std::is_integral_v<P> && e.there[size_t(t)] == 0) continue;
        const P pixel = this->at(x, s, border, value, i, r + t / e.kw - e.row, c + t % e.kw - e.column, k);
        const P height = std::is_integral_v<P> ? P(0) : P(heights[size_t(t)]);
        best = largest ? std::max<P>(best, P(pixel + height)) : std::min<P>(best, P(pixel - height));
      }
      return best;
    });
  };
  for (const Element& e : elements)
    for (const bool largest : {true, false})
      for (const bool flat : {true, false}) {
        for (const Border border : kBorders)
          for (const Size& s : kSizes) check(s, e, border, largest, flat);
        for (const Size& s : kWide) check(s, e, Border::kReflect, largest, flat);
      }
}

TYPED_TEST(Windows, MorphologyGradientIsDilationMinusErosion) {
  using P = TypeParam;
  const std::vector<double> disk{-kAbsent, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -kAbsent, 0, 0}, box(15, 0.0);
  const P high_value = std::is_integral_v<P> ? P(7) : P(0.25),
          low_value = std::is_integral_v<P> ? P(250) : P(0.75);
  for (const Size& s : kSizes)
    for (const Border border : kBorders) {
      const auto x = this->random(s.values());
      std::vector<P> out(x.size()), largest(x.size()), smallest(x.size());
      morphology_gradient(x.data(), s.count, s.height, s.length(), s.step, disk.data(), 5, 3, box.data(), 2,
                          0, border, high_value, low_value, kAbsent, out.data());
      morphology(x.data(), s.count, s.height, s.length(), s.step, disk.data(), 5, 3, 2, 0, border, high_value,
                 kAbsent, true, largest.data());
      morphology(x.data(), s.count, s.height, s.length(), s.step, box.data(), 5, 3, 2, 0, border, low_value,
                 kAbsent, false, smallest.data());
      for (size_t i = 0; i < x.size(); ++i) {
        if constexpr (std::is_integral_v<P>)
          ASSERT_EQ(out[i], cv::saturate_cast<P>(int(largest[i]) - int(smallest[i])));
        else
          ASSERT_EQ(out[i], largest[i] - smallest[i]);
      }
    }
}

TYPED_TEST(Windows, MedianFilterMatchesItsDefinition) {
  using P = TypeParam;
  for (const int64_t size : {3, 5, 7}) {
    const auto check = [&](const Size& s, Border border) {
      const auto x = this->random(s.values());
      std::vector<P> out(x.size());
      median_filter(x.data(), s.count, s.height, s.length(), s.step, size, border, out.data());
      this->expect_ranks(x, out, s, size, size, size * size / 2, border);
    };
    for (const Border border : kBorders)
      for (const Size& s : kSizes) check(s, border);
    for (const Size& s : kWide) check(s, Border::kReflect);
  }
}

using WindowsOfBytes = Windows<uint8_t>;

TEST_F(WindowsOfBytes, MedianFilterMatchesOpenCv) {
  for (const Size& s : {Size{1, 40, 61, 3}, Size{1, 9, 300, 1}}) {
    const auto x = random(s.values());
    std::vector<uint8_t> out(x.size());
    for (const int64_t size : {3, 5, 7}) {
      median_filter(x.data(), 1, s.height, s.length(), s.step, size, Border::kReplicate, out.data());
      cv::Mat expected;
      cv::medianBlur(image_of(x, s, 0), expected, int(size));
      EXPECT_EQ(cv::norm(expected, image_of(out, s, 0), cv::NORM_INF), 0) << s << ", " << size;
    }
  }
}

TEST_F(WindowsOfBytes, RankOfBytesMatchesItsDefinition) {
  for (const auto& [ky, kx] :
       {std::pair<int64_t, int64_t>{1, 1}, {3, 3}, {5, 9}, {1, 33}, {35, 3}, {15, 15}}) {
    const auto check = [&, ky = ky, kx = kx](const Size& s, Border border) {
      auto x = random(s.values());
      for (uint8_t& v : x)
        if (engine_() % 2) v = uint8_t(v % 16);  // also many of few values
      std::vector<uint8_t> out(x.size());
      for (const int64_t rank : {int64_t{0}, ky * kx / 2, ky * kx - 1}) {
        rank_of_bytes(x.data(), s.count, s.height, s.length(), s.step, ky, kx, rank, border, out.data());
        expect_ranks(x, out, s, ky, kx, rank, border);
      }
    };
    for (const Border border : kBorders)
      for (const Size& s : kSizes) check(s, border);
    for (const Size& s : kWide) check(s, Border::kReflect);
  }
}

TEST_F(WindowsOfBytes, RankOfBytesCountsAsManyAsItMay) {
  const Size s{1, 5, 400, 1};
  const std::vector<uint8_t> x(size_t(s.values()), 255);
  std::vector<uint8_t> out(x.size());
  for (const auto& [ky, kx] : {std::pair<int64_t, int64_t>{255, 257}, {65535, 1}}) {
    rank_of_bytes(x.data(), 1, s.height, s.length(), 1, ky, kx, ky * kx - 1, Border::kReplicate, out.data());
    EXPECT_EQ(out, x);
  }
}

// The kernels on planes of floats, and on a frame of 1080 x 1920 x 3 bytes.
template <class Call>
auto on_frame(const Call& call) {
  return [call] {
    auto x = std::make_shared<std::vector<uint8_t>>(1080 * 1920 * 3);
    std::mt19937 engine(1);
    for (uint8_t& v : *x) v = uint8_t(engine());
    return [call, x, out = std::make_shared<std::vector<uint8_t>>(x->size())] {
      call(x->data(), 1, 1080, 1920 * 3, 3, out->data());
    };
  };
}

#define WINDOWS_BENCHMARK(name, ...)                                \
  KERNEL_BENCHMARK(name, [](const float* x, Planes p, float* out) { \
    const auto call = __VA_ARGS__;                                  \
    call(x, p.count, p.height, p.width, 1, out);                    \
  });                                                               \
  KERNEL_CALL_BENCHMARK(name##_of_bytes, on_frame(__VA_ARGS__))

constexpr double kFlat[9] = {};

// An ellipse as OpenCV draws it, for a dilation.
const std::vector<double>& ellipse(int size) {
  static std::map<int, std::vector<double>> made;
  auto& heights = made[size];
  if (heights.empty())
    for (const uint8_t there : cv::Mat_<uint8_t>(cv::getStructuringElement(cv::MORPH_ELLIPSE, {size, size})))
      heights.push_back(there ? 0 : -kAbsent);
  return heights;
}

WINDOWS_BENCHMARK(minmax_filter_3x3,
                  [](const auto* x, int64_t n, int64_t h, int64_t l, int64_t step, auto* out) {
                    minmax_filter(x, n, h, l, step, 3, 3, Border::kReplicate, 0.0, true, out);
                  });
WINDOWS_BENCHMARK(minmax_filter_7x7,
                  [](const auto* x, int64_t n, int64_t h, int64_t l, int64_t step, auto* out) {
                    minmax_filter(x, n, h, l, step, 7, 7, Border::kReplicate, 0.0, true, out);
                  });
WINDOWS_BENCHMARK(minmax_filter_31x31,
                  [](const auto* x, int64_t n, int64_t h, int64_t l, int64_t step, auto* out) {
                    minmax_filter(x, n, h, l, step, 31, 31, Border::kReplicate, 0.0, true, out);
                  });
WINDOWS_BENCHMARK(morphology_3x3, [](const auto* x, int64_t n, int64_t h, int64_t l, int64_t step,
                                     auto* out) {
  morphology(x, n, h, l, step, kFlat, 3, 3, 1, 1, Border::kConstant, -1e4, kAbsent, true, out);
});
WINDOWS_BENCHMARK(morphology_ellipse_5x5, [](const auto* x, int64_t n, int64_t h, int64_t l, int64_t step,
                                             auto* out) {
  morphology(x, n, h, l, step, ellipse(5).data(), 5, 5, 2, 2, Border::kConstant, -1e4, kAbsent, true, out);
});
WINDOWS_BENCHMARK(morphology_ellipse_31x31,
                  [](const auto* x, int64_t n, int64_t h, int64_t l, int64_t step, auto* out) {
                    morphology(x, n, h, l, step, ellipse(31).data(), 31, 31, 15, 15, Border::kConstant, -1e4,
                               kAbsent, true, out);
                  });
WINDOWS_BENCHMARK(morphology_gradient_3x3, [](const auto* x, int64_t n, int64_t h, int64_t l, int64_t step,
                                              auto* out) {
  morphology_gradient(x, n, h, l, step, kFlat, 3, 3, kFlat, 1, 1, Border::kConstant, -1e4, 1e4, kAbsent, out);
});
WINDOWS_BENCHMARK(median_filter_3x3,
                  [](const auto* x, int64_t n, int64_t h, int64_t l, int64_t step, auto* out) {
                    median_filter(x, n, h, l, step, 3, Border::kReplicate, out);
                  });
WINDOWS_BENCHMARK(median_filter_5x5,
                  [](const auto* x, int64_t n, int64_t h, int64_t l, int64_t step, auto* out) {
                    median_filter(x, n, h, l, step, 5, Border::kReplicate, out);
                  });
WINDOWS_BENCHMARK(median_filter_7x7,
                  [](const auto* x, int64_t n, int64_t h, int64_t l, int64_t step, auto* out) {
                    median_filter(x, n, h, l, step, 7, Border::kReplicate, out);
                  });
KERNEL_CALL_BENCHMARK(rank_of_bytes_15x15, on_frame([](const uint8_t* x, int64_t n, int64_t h, int64_t l,
                                                       int64_t step, uint8_t* out) {
                        rank_of_bytes(x, n, h, l, step, 15, 15, 112, Border::kReplicate, out);
                      }));

}  // namespace
