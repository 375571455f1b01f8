// Maxima and means of the bins of boxes, and means of points in them, against plain loops.
#include <cmath>
#include <limits>

#include "benchmarks.h"
#include "fixture.h"
#include "kernels.h"

using namespace chiasm::kernels;

namespace {

constexpr int64_t kBatch = 2, kChannels = 3, kHeight = 9, kWidth = 11, kBoxes = 40, kRows = 2, kColumns = 3;

template <class T>
class Regions : public KernelsTest<T> {
 protected:
  Regions() : KernelsTest<T>(7) {}

  void SetUp() override {
    KernelsTest<T>::SetUp();
    const auto draw = [&](int64_t n, int64_t low, int64_t high) {
      std::vector<int64_t> values(static_cast<size_t>(n));
      for (int64_t& v : values) v = std::uniform_int_distribution<int64_t>(low, high)(this->engine_);
      return values;
    };
    image = draw(kBoxes, 0, kBatch - 1);
    top = draw(kBoxes * kRows, 0, kHeight);
    bottom = draw(kBoxes * kRows, 0, kHeight);
    left = draw(kBoxes * kColumns, 0, kWidth);
    right = draw(kBoxes * kColumns, 0, kWidth);
  }

  // Calls body(bin's number in the output, its plane, pixels) for every bin; `own` if each bin has planes.
  template <class Body>
  void for_bins(const std::vector<T>& x, bool own, const Body& body) const {
    int64_t number = 0;
    for (int64_t box = 0; box < kBoxes; ++box)
      for (int64_t c = 0; c < kChannels; ++c)
        for (int64_t i = 0; i < kRows; ++i)
          for (int64_t j = 0; j < kColumns; ++j) {
            int64_t plane = image[size_t(box)] * kChannels + c;
            if (own) plane = plane * kRows * kColumns + i * kColumns + j;
            std::vector<T> pixels;
            for (int64_t y = top[size_t(box * kRows + i)]; y < bottom[size_t(box * kRows + i)]; ++y)
              for (int64_t k = left[size_t(box * kColumns + j)]; k < right[size_t(box * kColumns + j)]; ++k)
                pixels.push_back(x[size_t((plane * kHeight + y) * kWidth + k)]);
            body(static_cast<size_t>(number++), pixels);
          }
  }

  std::vector<int64_t> image, top, bottom, left, right;
};
using Types = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Regions, Types);

TYPED_TEST(Regions, MaximaMatchTheDefinition) {
  using T = TypeParam;
  auto x = this->random(kBatch * kChannels * kHeight * kWidth, -5, -1);
  x[5] = std::numeric_limits<T>::quiet_NaN();
  std::vector<T> out(size_t(kBoxes * kChannels * kRows * kColumns), T(7));
  box_maxima(x.data(), Images{kBatch, kChannels, kHeight, kWidth}, this->image.data(), kBoxes,
             this->top.data(), kRows, this->bottom.data(), this->left.data(), kColumns, this->right.data(),
             out.data());
  this->for_bins(x, false, [&](size_t bin, const std::vector<T>& pixels) {
    T expected = pixels.empty() ? T(0) : pixels[0];
    for (const T v : pixels)
      expected = std::isnan(expected) || std::isnan(v) ? T(NAN) : std::max(expected, v);
    if (std::isnan(expected))
      EXPECT_TRUE(std::isnan(out[bin])) << bin;
    else
      EXPECT_EQ(out[bin], expected) << bin;
  });
}

TYPED_TEST(Regions, MeansMatchTheDefinition) {
  using T = TypeParam;
  const auto x = this->random(kBatch * kChannels * kRows * kColumns * kHeight * kWidth, -1, 1);
  std::vector<T> out(size_t(kBoxes * kChannels * kRows * kColumns), T(7));
  box_means(x.data(), kBatch, kChannels, kRows * kColumns, kHeight, kWidth, this->image.data(), kBoxes,
            this->top.data(), kRows, this->bottom.data(), this->left.data(), kColumns, this->right.data(),
            out.data());
  this->for_bins(x, true, [&](size_t bin, const std::vector<T>& pixels) {
    double sum = 0;
    for (const T v : pixels) sum += static_cast<double>(v);
    EXPECT_EQ(out[bin], pixels.empty() ? T(0) : static_cast<T>(sum / double(pixels.size()))) << bin;
  });
}

// The weight of a pixel at a position along an axis: the border pixels reach one pixel further out.
double share(double position, int64_t pixel, int64_t size) {
  if (!(position >= -1 && position <= double(size))) return 0;
  return std::max(0.0, 1 - std::abs(std::clamp(position, 0.0, double(size - 1)) - double(pixel)));
}

TYPED_TEST(Regions, BilinearMeansMatchTheDefinition) {
  using T = TypeParam;
  constexpr int64_t kDown = 2, kAcross = 3, kBins = kRows * kColumns;
  constexpr double kNear = sizeof(T) == sizeof(float) ? 1e-5 : 1e-13;
  auto rows = this->random(kBoxes * kRows * kDown, -2, kHeight + 1),
       columns = this->random(kBoxes * kColumns * kAcross, -2, kWidth + 1);
  // corners, borders, and what is no position
  const T odd[] = {T(0),        T(-1),        T(kHeight - 1), T(kHeight), std::numeric_limits<T>::quiet_NaN(),
                   T(INFINITY), T(-INFINITY), T(1e30)};
  std::copy(std::begin(odd), std::end(odd), rows.begin());
  std::copy(std::begin(odd), std::end(odd), columns.begin() + 5);
  for (const int64_t planes : {int64_t{1}, int64_t{2}, kBins}) {
    const auto x = this->random(kBatch * kChannels * planes * kHeight * kWidth, -1, 1);
    std::vector<T> out(size_t(kBoxes * kChannels * kBins), T(7));
    bilinear_means(x.data(), kBatch, kChannels, planes, kHeight, kWidth, this->image.data(), kBoxes,
                   rows.data(), kRows, kDown, columns.data(), kColumns, kAcross, kBins / planes, out.data());
    for (int64_t i = 0; i < kBoxes * kChannels * kBins; ++i) {
      const int64_t bin = i % kBins, c = i / kBins % kChannels, box = i / kBins / kChannels;
      const int64_t plane = (this->image[size_t(box)] * kChannels + c) * planes + bin / (kBins / planes);
      double sum = 0;
      for (int64_t j = 0; j < kDown * kAcross; ++j) {
        const T y = rows[size_t((box * kRows + bin / kColumns) * kDown + j / kAcross)],
                h = columns[size_t((box * kColumns + bin % kColumns) * kAcross + j % kAcross)];
        for (int64_t pixel = 0; pixel < kHeight * kWidth; ++pixel)
          sum += share(double(y), pixel / kWidth, kHeight) * share(double(h), pixel % kWidth, kWidth) *
                 double(x[size_t(plane * kHeight * kWidth + pixel)]);
      }
      EXPECT_NEAR(double(out[size_t(i)]), sum / (kDown * kAcross), kNear) << i;
    }
  }
}

// Untrusted numbers: they are limited to the images.
TYPED_TEST(Regions, NumbersOutsideTheImagesAreLimited) {
  using T = TypeParam;
  const auto x = this->random(kBatch * kHeight * kWidth, 1, 2);
  for (const int64_t far : {int64_t{1} << 40, INT64_MAX, INT64_MIN, int64_t{-1}}) {
    const int64_t image = far, low = INT64_MIN, high = INT64_MAX;
    T most = 0, mean = 0;
    box_maxima(x.data(), Images{kBatch, 1, kHeight, kWidth}, &image, 1, &low, 1, &high, &low, 1, &high,
               &most);
    box_means(x.data(), kBatch, 1, 1, kHeight, kWidth, &image, 1, &low, 1, &high, &low, 1, &high, &mean);
    const auto first = x.begin() + (far > 0 ? kHeight * kWidth : 0);
    EXPECT_EQ(most, *std::max_element(first, first + kHeight * kWidth));
    const T at = 2;
    T point = 0;
    bilinear_means(x.data(), kBatch, 1, 1, kHeight, kWidth, &image, 1, &at, 1, 1, &at, 1, 1, 1, &point);
    EXPECT_EQ(point, first[2 * kWidth + 2]);
    EXPECT_GT(mean, T(1));
    EXPECT_LT(mean, T(2));
  }
}

struct Setting {
  std::vector<float> x = std::vector<float>(size_t{16} * 49 * 100 * 100, 0.5f);
  std::vector<int64_t> image = std::vector<int64_t>(300, 0), low = std::vector<int64_t>(300 * 7),
                       high = std::vector<int64_t>(300 * 7);
  std::vector<float> points = std::vector<float>(300 * 7 * 2);
  std::vector<float> out = std::vector<float>(size_t{300} * 16 * 49);

  Setting() {
    for (int64_t i = 0; i < 300 * 7; ++i) low[size_t(i)] = i % 7 * 10, high[size_t(i)] = i % 7 * 10 + 11;
    for (size_t i = 0; i < points.size(); ++i) points[i] = 5.5f * float(i % 14) + 2.75f;
  }
};

}  // namespace

// 300 boxes of 77 x 77 pixels in maps of 100 x 100
KERNEL_CALL_BENCHMARK(box_maxima, [] {
  return [s = Setting()]() mutable {
    box_maxima(s.x.data(), Images{1, 16, 100, 100}, s.image.data(), 300, s.low.data(), 7, s.high.data(),
               s.low.data(), 7, s.high.data(), s.out.data());
  };
});
KERNEL_CALL_BENCHMARK(box_means, [] {
  return [s = Setting()]() mutable {
    box_means(s.x.data(), 1, 16, 49, 100, 100, s.image.data(), 300, s.low.data(), 7, s.high.data(),
              s.low.data(), 7, s.high.data(), s.out.data());
  };
});
KERNEL_CALL_BENCHMARK(bilinear_means, [] {
  return [s = Setting()]() mutable {
    bilinear_means(s.x.data(), 1, 16, 1, 100, 100, s.image.data(), 300, s.points.data(), 7, 2,
                   s.points.data(), 7, 2, 49, s.out.data());
  };
});
