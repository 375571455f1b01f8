// Shared parts of the kernels' tests: random numbers, and several threads.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "threads.h"

template <class T>
class KernelsTest : public ::testing::Test {
 protected:
  explicit KernelsTest(unsigned seed) : engine_(seed) {}

  void SetUp() override { use_threads(3); }

  std::vector<T> random(int64_t n, double low = 0, double high = 1) {
    std::uniform_real_distribution<double> draw(low, high);
    std::vector<T> values(static_cast<size_t>(n));
    for (T& v : values) v = static_cast<T>(draw(engine_));
    return values;
  }

  std::mt19937 engine_;
};
