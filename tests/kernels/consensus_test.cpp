// The kernels of robust estimation: chosen models against full costs in plain loops of doubles, and roots
// against those from which the polynomials were made.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "benchmarks.h"
#include "fixture.h"
#include "kernels.h"

using namespace chiasm::kernels;

namespace {

template <class T>
class Consensus : public KernelsTest<T> {
 protected:
  Consensus() : KernelsTest<T>(13) {}

  // Points whose partners are random, except for a third, which the first model, nearly the identity, maps to
  // their partners.
  std::vector<T> points(int64_t batch, int64_t n) {
    auto planes = this->random(batch * 7 * n, -1, 1);
    for (int64_t item = 0; item < batch; ++item) {
      T* const own = planes.data() + item * 7 * n;
      for (int64_t i = 0; i < n; ++i) {
        own[2 * n + i] = own[5 * n + i] = 1;
        own[6 * n + i] = T(0.01);
        for (const int64_t row : {0, 1})
          if (i % 3 == 0) own[(3 + row) * n + i] = own[row * n + i];
      }
    }
    return planes;
  }

  std::vector<T> models(int64_t count) {
    auto values = this->random(count * 9, -0.3, 0.3);
    for (int64_t m = 0; m < count; m += 1 + m / 4)
      for (const int64_t k : {0, 4, 8}) values[m * 9 + k] += 1;
    return values;
  }
};

template <class T>
double cost(const T* m, const T* planes, int64_t n, bool epipolar) {
  double sum = 0;
  for (int64_t i = 0; i < n; ++i) {
    const double p[3] = {planes[i], planes[n + i], 1}, q[3] = {planes[3 * n + i], planes[4 * n + i], 1};
    double forward[3], backward[3];
    for (int64_t r = 0; r < 3; ++r) {
      forward[r] = m[3 * r] * p[0] + m[3 * r + 1] * p[1] + m[3 * r + 2];
      backward[r] = m[r] * q[0] + m[3 + r] * q[1] + m[6 + r];
    }
    const double product = forward[0] * q[0] + forward[1] * q[1] + forward[2],
                 u = forward[0] / forward[2] - q[0], v = forward[1] / forward[2] - q[1];
    const double slopes = forward[0] * forward[0] + forward[1] * forward[1] + backward[0] * backward[0] +
                          backward[1] * backward[1];
    const double error = epipolar ? product * product / slopes : u * u + v * v;
    if (std::isnan(error)) return std::numeric_limits<double>::infinity();
    sum += std::min(error, double(planes[6 * n + i]));
  }
  return sum;
}

using Types = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Consensus, Types);

TYPED_TEST(Consensus, TakesTheCheapest) {
  constexpr int64_t batch = 3;
  for (const int64_t n : {1, 4, 9, 131, 1000})
    for (const int64_t count : {1, 2, 7, 100})
      for (const bool epipolar : {false, true}) {
        const auto planes = this->points(batch, n), models = this->models(batch * count);
        const int64_t wanted = std::min<int64_t>(count, 4);
        int64_t index[batch * 4];
        score_models(models.data(), batch, count, planes.data(), n, epipolar, wanted, index);
        for (int64_t item = 0; item < batch; ++item) {
          std::vector<double> costs;
          for (int64_t m = 0; m < count; ++m)
            costs.push_back(
                cost(models.data() + (item * count + m) * 9, planes.data() + item * 7 * n, n, epipolar));
          auto sorted = costs;
          std::sort(sorted.begin(), sorted.end());
          // Models whose costs differ only by rounding may come in either order.
          for (int64_t k = 0; k < wanted; ++k)
            EXPECT_NEAR(costs[index[item * wanted + k]], sorted[k], 1e-5 * (1 + sorted[k]))
                << n << " points, " << count << " models";
        }
      }
}

KERNEL_CALL_BENCHMARK(score_models, [] {
  return [models = kernel_benchmarks::random(1000 * 9), points = kernel_benchmarks::random(7 * 2000),
          best = std::vector<int64_t>(4)]() mutable {
    score_models(models.data(), 1, 1000, points.data(), 2000, false, 4, best.data());
  };
});

TYPED_TEST(Consensus, OfEqualsTheFirstAndNothingThatIsNoModel) {
  using T = TypeParam;
  constexpr int64_t n = 50, count = 60;
  const auto planes = this->points(1, n);
  const T nan = std::numeric_limits<T>::quiet_NaN();
  for (const bool epipolar : {false, true}) {
    std::vector<T> models(count * 9, T(0));
    // Zeros, except for one NaN and two equal models, which different threads may evaluate.
    models[3 * 9 + 4] = nan;
    const auto good = this->models(1);
    for (const int64_t m : {9, 55}) std::copy(good.begin(), good.end(), models.begin() + m * 9);
    std::vector<int64_t> index(3, -1);
    score_models(models.data(), 1, count, planes.data(), n, epipolar, 3, index.data());
    EXPECT_EQ(index, (std::vector<int64_t>{9, 55, 0}));
  }
}

class RealRoots : public KernelsTest<double> {
 protected:
  RealRoots() : KernelsTest<double>(17) {}
};

TEST_F(RealRoots, AreThoseThatThePolynomialIsMadeOf) {
  std::uniform_real_distribution<double> draw(-1, 1);
  for (const int64_t degree : {1, 2, 3, 7, 10, 16})
    for (const int64_t count : {1, 4, 5, 30}) {
      std::vector<double> c(static_cast<size_t>((degree + 1) * count)),
          places(static_cast<size_t>(2 * degree * count));
      std::vector<std::vector<double>> made(static_cast<size_t>(count));
      for (int64_t i = 0; i < count; ++i) {
        // Some real roots, at least 0.05 apart, and pairs of complex ones for the rest.
        std::vector<double> p{draw(engine_) < 0 ? -2.0 : 0.5};
        const auto times = [&p](const std::vector<double>& factor) {
          std::vector<double> product(p.size() + factor.size());
          for (size_t a = 0; a < p.size(); ++a)
            for (size_t b = 0; b < factor.size(); ++b) product[a + b] += p[a] * factor[b];
          product.pop_back();
          p = product;
        };
        auto& roots = made[i];
        while (static_cast<int64_t>(p.size()) <= degree) {
          const double root = 2 * draw(engine_);
          const bool single = static_cast<int64_t>(p.size()) == degree || draw(engine_) < 0;
          if (single &&
              std::any_of(roots.begin(), roots.end(), [&](double r) { return std::abs(r - root) < 0.05; }))
            continue;
          times(single ? std::vector<double>{-root, 1}
                       : std::vector<double>{root * root + 0.2 + std::abs(draw(engine_)), -2 * root, 1});
          if (single) roots.push_back(root);
        }
        std::sort(roots.begin(), roots.end());
        for (int64_t k = 0; k <= degree; ++k) c[k * count + i] = p[k];
      }
      real_roots(c.data(), degree + 1, count, places.data());
      const double* const exist = places.data() + degree * count;
      for (int64_t i = 0; i < count; ++i) {
        std::vector<double> found;
        for (int64_t k = 0; k < degree; ++k) {
          const double u = places[k * count + i];
          EXPECT_GE(u, k > 0 ? places[(k - 1) * count + i] : -1);
          if (exist[k * count + i] != 0) found.push_back(u / (1 - std::abs(u)));
        }
        ASSERT_EQ(found.size(), made[i].size()) << "degree " << degree;
        // At degree 16, rounding of the coefficients moves the roots by more than their own rounding.
        for (size_t k = 0; k < found.size(); ++k)
          EXPECT_NEAR(found[k], made[i][k], degree > 10 ? 1e-5 : 1e-8) << "degree " << degree;
      }
    }
}

KERNEL_CALL_BENCHMARK(real_roots, [] {
  std::vector<double> c(11 * 1000);
  for (size_t i = 0; i < c.size(); ++i) c[i] = double(i * 7919 % 1009) / 504.5 - 1;
  return
      [c, out = std::vector<double>(2 * 10 * 1000)]() mutable { real_roots(c.data(), 11, 1000, out.data()); };
});

TEST_F(RealRoots, OfWhatHasNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  // Zeros, a constant, no real root, NaN; then x, whose root is 0.
  const std::vector<double> c{0, 3, 1, nan, 0, 0, 0, 0, 1, 1, 0, 0, 1, 1, 0};
  std::vector<double> places(20);
  real_roots(c.data(), 3, 5, places.data());
  const double* const exist = places.data() + 10;
  for (int64_t i = 0; i < 4; ++i) EXPECT_EQ(exist[i] + exist[5 + i], 0) << i;
  EXPECT_EQ(exist[4] + exist[9], 1);
  EXPECT_EQ(exist[4] != 0 ? places[4] : places[9], 0);
}

}  // namespace
