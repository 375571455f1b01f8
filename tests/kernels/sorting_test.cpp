// The largest and smallest values of rows (runtime/artifact/aoti/sorting.h) against std::stable_sort.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "calls.h"
#include "threads.h"

using kernel_calls::Tensor;

namespace {

// NaN is the largest, -0 equals 0.
template <class T>
bool less(T x, T y) {
  return x != x ? false : y != y ? true : x < y;
}

// Few different values, which give many ties, or all values of the type.
template <class T>
std::vector<T> values_of(int64_t n, bool few) {
  using Limits = std::numeric_limits<T>;
  std::mt19937_64 engine(static_cast<uint64_t>(n));
  std::vector<T> values(static_cast<size_t>(n));
  for (T& each : values) {
    if constexpr (std::is_floating_point_v<T>) {
      const T special[] = {
          Limits::quiet_NaN(), -Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity(), T(0), T(-0.0),
          Limits::lowest(),    Limits::denorm_min()};
      each = few ? special[engine() % std::size(special)] : std::normal_distribution<T>()(engine);
    } else {
      each = few ? static_cast<T>(engine() % 7) - 3 : static_cast<T>(engine());
    }
  }
  return values;
}

template <class T>
class Topk : public ::testing::Test {};
using Types = ::testing::Types<float, double, int32_t, int64_t>;
TYPED_TEST_SUITE(Topk, Types);

TYPED_TEST(Topk, IsTheBeginningOfAStableSort) {
  using T = TypeParam;
  use_threads(3);
  constexpr int64_t kRows = 4;
  for (const int64_t n : {1, 7, 1023, 1024, 5000})
    for (const bool few : {false, true})
      for (const bool largest : {false, true})
        for (const int64_t k : {n, n - 1, n / 16, n / 17, std::min<int64_t>(n, 1)}) {
          const std::vector<T> values = values_of<T>(kRows * n, few);
          const Tensor x = kernel_calls::of({kRows, n}, values);
          Handle made = nullptr, places = nullptr;
          ASSERT_EQ(aoti_torch_cpu_topk(x.get(), k, -1, largest, 1, &made, &places), 0)
              << kernel_calls::last_error;
          const Tensor top(made), index(places);
          for (int64_t row = 0; row < kRows; ++row) {
            const T* const own = values.data() + row * n;
            std::vector<int64_t> order(static_cast<size_t>(n));
            std::iota(order.begin(), order.end(), 0);
            std::stable_sort(order.begin(), order.end(), [&](int64_t a, int64_t b) {
              return largest ? less(own[b], own[a]) : less(own[a], own[b]);
            });
            for (int64_t i = 0; i < k; ++i) {
              const auto place = static_cast<size_t>(i);
              ASSERT_EQ(reinterpret_cast<const int64_t*>(index->data())[row * k + i], order[place])
                  << n << " values, " << k << " of them, largest " << largest << ", place " << i;
              const T value = reinterpret_cast<const T*>(top->data())[row * k + i],
                      expected = own[order[place]];
              ASSERT_TRUE(value == expected || (value != value && expected != expected));
            }
          }
        }
}

}  // namespace
