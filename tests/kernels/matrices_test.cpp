// The kernels for small matrices, against OpenCV's inverses and powers in plain loops.
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "benchmarks.h"
#include "fixture.h"
#include "kernels.h"

using namespace chiasm::kernels;

namespace {

class Matrices : public KernelsTest<double> {
 protected:
  Matrices() : KernelsTest<double>(19) {}
};

cv::Mat item(const std::vector<double>& values, int64_t n, int64_t i) {
  return cv::Mat(int(n), int(n), CV_64F, const_cast<double*>(values.data()) + i * n * n);
}

double difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF) / cv::norm(b, cv::NORM_INF);
}

TEST_F(Matrices, InversesMatchOpenCv) {
  for (const int64_t n : {1, 2, 3, 4, 5, 9, 10, 16})
    for (const int64_t count : {1, 7}) {
      const auto m = random(count * n * n, -1, 1);
      std::vector<double> symmetric(m.size()), general(m.size()), out(m.size());
      for (int64_t i = 0; i < count; ++i) {
        cv::Mat a = item(m, n, i), b = item(general, n, i), c = item(symmetric, n, i);
        // Zeros on the diagonal cannot be pivots.
        a.copyTo(b);
        for (int k = 0; k < n && n > 1; ++k) b.at<double>(k, k) = 0;
        cv::Mat(a * a.t() + 0.1 * cv::Mat::eye(int(n), int(n), CV_64F)).copyTo(c);
      }
      batched_inverse(general.data(), count, n, out.data());
      for (int64_t i = 0; i < count; ++i)
        EXPECT_LT(difference(item(out, n, i), item(general, n, i).inv(cv::DECOMP_SVD)), 1e-9) << n;
      spd_inverse(symmetric.data(), count, n, out.data());
      for (int64_t i = 0; i < count; ++i)
        EXPECT_LT(difference(item(out, n, i), item(symmetric, n, i).inv(cv::DECOMP_CHOLESKY)), 1e-10) << n;
    }
}

std::vector<double> identities() {
  std::vector<double> m(1000 * 81);
  for (size_t i = 0; i < m.size(); ++i) m[i] = i % 81 % 10 == 0 ? 1 : double(i * 7919 % 101) / 1e4;
  return m;
}

KERNEL_CALL_BENCHMARK(batched_inverse, [] {
  return [m = identities(), out = std::vector<double>(1000 * 81)]() mutable {
    batched_inverse(m.data(), 1000, 9, out.data());
  };
});
KERNEL_CALL_BENCHMARK(spd_inverse, [] {
  return [m = identities(), out = std::vector<double>(1000 * 81)]() mutable {
    spd_inverse(m.data(), 1000, 9, out.data());
  };
});

TEST_F(Matrices, OfASingularMatrixThereIsNoInverse) {
  const std::vector<double> m{1, 2, 3, 2, 4, 6, 1, 0, 1};
  std::vector<double> out(9, 0);
  batched_inverse(m.data(), 1, 3, out.data());
  bool finite = true;
  for (const double v : out) finite = finite && std::isfinite(v);
  EXPECT_FALSE(finite);
}

TEST_F(Matrices, NormalizedPowerMatchesItsDefinition) {
  for (const int64_t n : {1, 3, 4, 9, 16})
    for (const int64_t squarings : {0, 1, 7}) {
      constexpr int64_t count = 5;
      const auto m = random(count * n * n, 0, 1);
      std::vector<double> out(m.size());
      normalized_power(m.data(), count, n, squarings, out.data());
      for (int64_t i = 0; i < count; ++i) {
        cv::Mat expected = item(m, n, i).clone();
        for (int64_t s = 0; s < squarings; ++s) {
          expected /= cv::trace(expected)[0];
          expected = expected * expected;
        }
        EXPECT_LT(difference(item(out, n, i), expected), 1e-12) << n << ", " << squarings;
      }
    }
}

KERNEL_CALL_BENCHMARK(normalized_power, [] {
  return [m = identities(), out = std::vector<double>(1000 * 81)]() mutable {
    normalized_power(m.data(), 1000, 9, 6, out.data());
  };
});

TEST_F(Matrices, WeightedGramsMatchOpenCv) {
  for (const int64_t n : {1, 2, 3, 4, 5, 9, 16})
    for (const int64_t rows : {0, 1, 7, 64, 300})
      for (const int64_t sets : {1, 3}) {
        constexpr int64_t batch = 2;
        const auto x = random(batch * rows * n, -1, 1), weights = random(batch * rows * sets, -1, 1);
        std::vector<double> out(size_t(batch * sets * n * n));
        weighted_grams(x.data(), batch, rows, n, weights.data(), sets, out.data());
        for (int64_t i = 0; i < batch * sets; ++i) {
          cv::Mat expected = cv::Mat::zeros(int(n), int(n), CV_64F);
          for (int64_t r = 0; r < rows; ++r) {
            const int64_t at = i / sets * rows + r;
            const cv::Mat row(1, int(n), CV_64F, const_cast<double*>(x.data() + at * n));
            expected += weights[size_t(at * sets + i % sets)] * row.t() * row;
          }
          EXPECT_LE(cv::norm(item(out, n, i), expected, cv::NORM_INF), 1e-13 * double(rows))
              << n << ", " << rows;
        }
      }
}

KERNEL_CALL_BENCHMARK(weighted_grams, [] {
  return [x = std::vector<double>(10000 * 9, 0.3), weights = std::vector<double>(10000, 0.7),
          out = std::vector<double>(81)]() mutable {
    weighted_grams(x.data(), 1, 10000, 9, weights.data(), 1, out.data());
  };
});

}  // namespace
