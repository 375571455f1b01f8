// Extreme values and sums of rows, against OpenCV and plain loops.
#include <limits>

#include "benchmarks.h"
#include "bytes.h"
#include "kernels.h"
#include "threads.h"

using namespace chiasm::kernels;

namespace {

// Few different values, so that extremes occur several times; with `special`, also NaN and infinities.
template <class P>
std::vector<P> row_of(int64_t n, unsigned seed, bool special) {
  std::mt19937 engine(seed);
  std::vector<P> values(static_cast<size_t>(n));
  for (P& v : values) v = static_cast<P>(static_cast<int>(engine() % 7) + 60);
  if constexpr (std::is_floating_point_v<P>)
    for (P& v : values)
      if (special && engine() % 2 == 0)
        v = engine() % 4 == 0 ? std::numeric_limits<P>::infinity() : std::numeric_limits<P>::quiet_NaN();
  return values;
}

template <class P>
int64_t expected_index(const P* x, int64_t n, bool greatest) {
  int64_t best = -1;
  for (int64_t i = 0; i < n; ++i)
    if (x[i] == x[i] && (best < 0 || (greatest ? x[i] > x[best] : x[i] < x[best]))) best = i;
  return std::max<int64_t>(best, 0);
}

// Channel `c` of interleaved pixels.
template <class P>
std::vector<P> channel(const std::vector<P>& x, int64_t pixels, int64_t step, int64_t c) {
  std::vector<P> values;
  for (int64_t i = 0; i < pixels; ++i) values.push_back(x[static_cast<size_t>(i * step + c)]);
  return values;
}

// The places of the extremes of each channel of interleaved pixels are those of a plain loop.
template <class P>
void expect_first_extremes(const std::vector<P>& x, int64_t pixels, int64_t step) {
  std::vector<int64_t> index(static_cast<size_t>(2 * step), -1);
  extreme_indices(x.data(), 1, step * pixels, step, index.data());
  for (int64_t c = 0; c < step; ++c) {
    const std::vector<P> values = channel(x, pixels, step, c);
    const auto at = static_cast<size_t>(2 * c);
    ASSERT_EQ(index[at], expected_index(values.data(), pixels, false)) << step << ", " << pixels;
    ASSERT_EQ(index[at + 1], expected_index(values.data(), pixels, true)) << step << ", " << pixels;
  }
}

template <class P>
class Statistics : public ::testing::Test {};
using Pixels = ::testing::Types<uint8_t, int16_t, uint16_t, float, double>;
TYPED_TEST_SUITE(Statistics, Pixels);

TYPED_TEST(Statistics, TheFirstExtremesAreFound) {
  using P = TypeParam;
  for (const int threads : {1, 3})
    for (const int64_t step : {1, 2, 3, 4, 5, 5000})
      for (const int64_t pixels : {1, 2, 7, 33, 129, 1000, 13000})
        for (unsigned seed = 0; seed < 6; ++seed) {
          if (step * pixels > 200000) continue;
          use_threads(threads);
          std::vector<P> x = row_of<P>(step * pixels, seed, seed % 2 == 1);
          if (seed == 0) std::fill(x.begin(), x.end(), x[0]);
          ASSERT_NO_FATAL_FAILURE(expect_first_extremes(x, pixels, step));
        }
  use_threads(1);
}

TYPED_TEST(Statistics, EachPartOfARowMayHaveABetterValue) {
  using P = TypeParam;
  constexpr int64_t kPixels = 9000;
  for (const bool rises : {false, true})
    for (const int64_t step : {1, 2, 3, 4}) {
      std::mt19937 engine(7);
      std::vector<P> x;
      for (int64_t i = 0; i < kPixels * step; ++i) {
        const int64_t height = 100 * i / (kPixels * step);
        x.push_back(static_cast<P>((rises ? height : 100 - height) + static_cast<int64_t>(engine() % 3)));
      }
      ASSERT_NO_FATAL_FAILURE(expect_first_extremes(x, kPixels, step)) << rises;
    }
}

TYPED_TEST(Statistics, LimitsOfTheTypeAreFound) {
  using P = TypeParam;
  for (const P value : {std::numeric_limits<P>::lowest(), std::numeric_limits<P>::max()}) {
    const std::vector<P> x(100, value);
    int64_t index[] = {-1, -1};
    extreme_indices(x.data(), 1, 100, 1, index);
    EXPECT_EQ(index[0], 0);
    EXPECT_EQ(index[1], 0);
  }
}

TEST_F(Bytes, ExtremesMatchOpenCv) {
  for (const Size& size : kSizes) {
    const cv::Mat image = frame(size.height, size.width, 1);
    cv::Point least, most;
    cv::minMaxLoc(image, nullptr, nullptr, &least, &most);
    int64_t index[2] = {};
    extreme_indices(image.data, 1, static_cast<int64_t>(image.total()), 1, index);
    EXPECT_EQ(index[0], least.y * size.width + least.x);
    EXPECT_EQ(index[1], most.y * size.width + most.x);
  }
}

TEST_F(Bytes, MomentsAreExact) {
  for (const int threads : {1, 3})
    for (const int64_t step : {1, 3, 4, 5})
      for (const int64_t pixels : {1, 15, 16, 17, 33, 1000, 300000}) {
        use_threads(threads);
        const int64_t n = pixels * step;
        std::vector<uint8_t> x(static_cast<size_t>(2 * n), 255);  // the second row has the largest sums
        std::mt19937 engine(3);
        for (int64_t i = 0; i < n; ++i) x[static_cast<size_t>(i)] = static_cast<uint8_t>(engine());
        std::vector<int64_t> out(static_cast<size_t>(4 * step), -1);
        moments_bytes(x.data(), 2, n, step, out.data());
        for (int64_t c = 0; c < step; ++c) {
          int64_t sum = 0, squares = 0;
          for (const int64_t v : channel(x, pixels, step, c)) sum += v, squares += v * v;
          const int64_t* const first = out.data() + 2 * c;
          const int64_t* const second = first + 2 * step;
          ASSERT_EQ(first[0], sum) << step << ", " << pixels;
          ASSERT_EQ(first[1], squares);
          ASSERT_EQ(second[0], 255 * pixels);
          ASSERT_EQ(second[1], 65025 * pixels);
        }
      }
  use_threads(1);
}

}  // namespace

KERNEL_CALL_BENCHMARK(extreme_indices, [] {
  return [x = kernel_benchmarks::random(3 * 1080 * 1920), out = std::vector<int64_t>(6)]() mutable {
    extreme_indices(x.data(), 3, 1080 * 1920, 1, out.data());
  };
});
KERNEL_CALL_BENCHMARK(extreme_indices_of_frames, [] {
  return [frame = Frame(), out = std::vector<int64_t>(6)]() mutable {
    extreme_indices(frame.x.data(), 1, 1080 * 1920 * 3, 3, out.data());
  };
});
KERNEL_CALL_BENCHMARK(moments_bytes, [] {
  return [frame = Frame(), out = std::vector<int64_t>(6)]() mutable {
    moments_bytes(frame.x.data(), 3, 1080 * 1920, 1, out.data());
  };
});
KERNEL_CALL_BENCHMARK(moments_bytes_of_frames, [] {
  return [frame = Frame(), out = std::vector<int64_t>(6)]() mutable {
    moments_bytes(frame.x.data(), 1, 1080 * 1920 * 3, 3, out.data());
  };
});
