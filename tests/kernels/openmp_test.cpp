// The artifacts' own OpenMP functions, by pragmas as the kernels have them.
#include <gtest/gtest.h>

#include <atomic>

#include "threads.h"

TEST(OpenMp, ARegionWhoseConditionIsFalseHasOneThread) {
  use_threads(3);
  for (const bool condition : {false, true}) {
    std::atomic<int> entered = 0;
#pragma omp parallel if (condition)
    ++entered;
    EXPECT_EQ(entered, condition ? 3 : 1);
  }
}
