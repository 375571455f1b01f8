// What tests of the kernels share: numbers at random, and more threads than one.
#pragma once

#include <gtest/gtest.h>
#include <omp.h>

#include <cstdint>
#include <random>
#include <vector>

/** More threads than one; under ThreadSanitizer one, because g++'s OpenMP library synchronises in ways that it does not see. */
inline void use_several_threads() {
#ifdef __SANITIZE_THREAD__
  omp_set_num_threads(1);
#else
  omp_set_num_threads(3);
#endif
}

template <class T>
class KernelsTest : public ::testing::Test {
 protected:
  explicit KernelsTest(unsigned seed) : engine_(seed) {}

  void SetUp() override { use_several_threads(); }

  std::vector<T> random(int64_t n, double low = 0, double high = 1) {
    std::uniform_real_distribution<double> draw(low, high);
    std::vector<T> values(static_cast<size_t>(n));
    for (T& v : values) v = static_cast<T>(draw(engine_));
    return values;
  }

  std::mt19937 engine_;
};
