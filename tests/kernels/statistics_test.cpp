// Extreme values and sums of rows, against OpenCV and plain loops.
#include <limits>

#include "benchmarks.h"
#include "bytes.h"
#include "kernels.h"

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

template <class P>
class Statistics : public ::testing::Test {};
using Pixels = ::testing::Types<uint8_t, int16_t, uint16_t, float, double>;
TYPED_TEST_SUITE(Statistics, Pixels);

TYPED_TEST(Statistics, TheFirstExtremeIsFound) {
  using P = TypeParam;
  for (const int64_t n : {1, 2, 7, 16, 33, 64, 129, 300, 1000})
    for (unsigned seed = 0; seed < 20; ++seed)
      for (const bool special : {false, true}) {
        std::vector<P> x = row_of<P>(2 * n, seed, special);
        if (seed == 0) std::fill_n(x.begin(), n, x[0]);
        for (const bool greatest : {false, true}) {
          int64_t index[2] = {};
          extreme_index(x.data(), 2, n, greatest, index);
          for (int64_t row = 0; row < 2; ++row)
            ASSERT_EQ(index[row], expected_index(x.data() + row * n, n, greatest)) << n << ", " << seed;
        }
      }
}

TYPED_TEST(Statistics, LimitsOfTheTypeAreFound) {
  using P = TypeParam;
  for (const P value : {std::numeric_limits<P>::lowest(), std::numeric_limits<P>::max()})
    for (const bool greatest : {false, true}) {
      const std::vector<P> x(100, value);
      int64_t index = -1;
      extreme_index(x.data(), 1, 100, greatest, &index);
      EXPECT_EQ(index, 0);
    }
}

TEST_F(Bytes, ExtremesMatchOpenCv) {
  for (const Size& size : kSizes) {
    const cv::Mat image = frame(size.height, size.width, 1);
    cv::Point least, most;
    cv::minMaxLoc(image, nullptr, nullptr, &least, &most);
    int64_t first = 0, last = 0;
    extreme_index(image.data, 1, static_cast<int64_t>(image.total()), false, &first);
    extreme_index(image.data, 1, static_cast<int64_t>(image.total()), true, &last);
    EXPECT_EQ(first, least.y * size.width + least.x);
    EXPECT_EQ(last, most.y * size.width + most.x);
  }
}

TEST_F(Bytes, MomentsAreExact) {
  for (const int64_t n : {1, 15, 16, 17, 33, 1000, 300000}) {
    std::vector<uint8_t> x(static_cast<size_t>(2 * n), 255);  // the second row has the largest sums
    std::mt19937 engine(3);
    for (int64_t i = 0; i < n; ++i) x[static_cast<size_t>(i)] = static_cast<uint8_t>(engine());
    int64_t out[4];
    moments_bytes(x.data(), 2, n, out);
    int64_t sum = 0, squares = 0;
    for (int64_t i = 0; i < n; ++i) {
      const int64_t v = x[static_cast<size_t>(i)];
      sum += v, squares += v * v;
    }
    EXPECT_EQ(out[0], sum);
    EXPECT_EQ(out[1], squares);
    EXPECT_EQ(out[2], 255 * n);
    EXPECT_EQ(out[3], 65025 * n);
  }
}

}  // namespace

KERNEL_CALL_BENCHMARK(extreme_index, [] {
  return [x = kernel_benchmarks::random(3 * 1080 * 1920), out = std::vector<int64_t>(3)]() mutable {
    extreme_index(x.data(), 3, 1080 * 1920, false, out.data());
  };
});
KERNEL_CALL_BENCHMARK(moments_bytes, [] {
  return [frame = Frame(), out = std::vector<int64_t>(6)]() mutable {
    moments_bytes(frame.x.data(), 3, 1080 * 1920, out.data());
  };
});
