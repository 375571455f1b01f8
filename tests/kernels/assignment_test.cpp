// Linear assignment against the best of all assignments.
#include "kernels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "benchmarks.h"
#include "fixture.h"

using namespace chiasm::kernels;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class AssignedColumns : public KernelsTest<double> {
 protected:
  AssignedColumns() : KernelsTest(1) {}

  // Whole numbers, whose sums are exact; many of few different ones are equal.
  std::vector<double> costs(int64_t count, int different, double forbidden) {
    std::vector<double> made = random(count, 0, different);
    for (double& cost : made) cost = random(1)[0] < forbidden ? kInfinity : std::floor(cost);
    return made;
  }
};

// The least sum of costs, by dynamic programming over the sets of columns that are taken.
double least_sum(const double* costs, int64_t n, int64_t m, double alone) {
  std::vector<double> least(size_t{1} << m, kInfinity);
  least[0] = 0;
  for (int64_t i = 0; i < n; ++i) {
    std::vector<double> next(least.size());
    for (size_t set = 0; set < least.size(); ++set) {
      next[set] = least[set] + alone;
      for (int64_t j = 0; j < m; ++j)
        if (set >> j & 1) next[set] = std::min(next[set], least[set ^ (size_t{1} << j)] + costs[i * m + j]);
    }
    least = std::move(next);
  }
  return *std::min_element(least.begin(), least.end());
}

}  // namespace

TEST_F(AssignedColumns, HaveTheLeastSumOfAllAssignments) {
  constexpr int64_t kMatrices = 20;
  for (const int64_t n : {0, 1, 2, 5, 12})
    for (const int64_t m : {1, 3, 4, 7, 9})
      for (const int different : {2, 1000})
        for (const double forbidden : {0.0, 0.5, 1.0}) {
          const auto c = costs(kMatrices * n * m, different, forbidden);
          // A cost of staying alone that is more than any sum of costs, and one only just above each cost.
          for (const double alone : {double(different) * double(n + 2), double(different)}) {
            const std::vector<double> all(kMatrices, alone);
            std::vector<int64_t> out(static_cast<size_t>(kMatrices * n));
            linear_sum_assignment(c.data(), kMatrices, n, m, all.data(), out.data());
            for (int64_t b = 0; b < kMatrices; ++b) {
              double sum = 0;
              std::multiset<int64_t> taken;
              for (int64_t i = 0; i < n; ++i) {
                const int64_t column = out[b * n + i];
                ASSERT_TRUE(-1 <= column && column < m);
                sum += column < 0 ? alone : c[(b * n + i) * m + column];
                if (column >= 0) taken.insert(column);
              }
              EXPECT_EQ(sum, least_sum(c.data() + b * n * m, n, m, alone)) << n << " x " << m;
              for (const int64_t column : taken) EXPECT_EQ(taken.count(column), 1u);
            }
          }
        }
}

TEST_F(AssignedColumns, TakeTheLowestColumnOfEquals) {
  const std::vector<double> c(6 * 9, 2.5), alone{100};
  std::vector<int64_t> out(6);
  linear_sum_assignment(c.data(), 1, 6, 9, alone.data(), out.data());
  EXPECT_EQ(out, (std::vector<int64_t>{0, 1, 2, 3, 4, 5}));
}

// With NaN, infinities and huge numbers, which callers exclude, the loops end, and columns are valid.
TEST_F(AssignedColumns, EndsWithoutAnOrder) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double odd : {nan, -kInfinity, 1e308, -1e308})
    for (const double alone : {1.0, kInfinity, nan}) {
      std::vector<double> c = costs(11 * 9, 5, 0.3);
      for (size_t i = 0; i < c.size(); i += 2) c[i] = odd;
      std::vector<int64_t> out(11);
      linear_sum_assignment(c.data(), 1, 11, 9, &alone, out.data());
      for (const int64_t column : out) EXPECT_TRUE(-1 <= column && column < 9);
    }
}

KERNEL_CALL_BENCHMARK(linear_sum_assignment, [] {
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> draw(0, 1);
  std::vector<double> c(300 * 305);
  for (double& cost : c) cost = draw(engine);
  return [c, alone = 1000.0, out = std::vector<int64_t>(300)]() mutable {
    linear_sum_assignment(c.data(), 1, 300, 305, &alone, out.data());
  };
});
