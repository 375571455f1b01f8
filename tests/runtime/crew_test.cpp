// The threads of the Triton backend, without Triton.
#include "triton/crew.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

namespace chiasm::triton {
namespace {

TEST(Crew, DoesEveryPieceOnce) {
  for (const size_t threads : {size_t{0}, size_t{1}, size_t{3}}) {
    Crew crew(threads);
    for (const size_t count : {size_t{0}, size_t{1}, size_t{2}, size_t{100}}) {
      std::vector<std::atomic<int>> done(count);
      crew.run(count, [&](size_t i) { ++done[i]; });
      for (const auto& each : done) EXPECT_EQ(each, 1);
    }
  }
}

TEST(Crew, WorksAtOnce) {
  Crew crew(3);
  std::atomic<int> there{0};
  // Each piece waits for all others, so with fewer threads this would never end.
  crew.run(4, [&](size_t) {
    ++there;
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (there < 4 && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
  });
  EXPECT_EQ(there, 4);
}

TEST(Crew, ServesManyCallersAtOnce) {
  Crew crew(2);
  std::vector<std::thread> callers;
  std::atomic<int> wrong{0};
  for (int caller = 0; caller < 6; ++caller) {
    callers.emplace_back([&] {
      for (size_t round = 0; round < 300; ++round) {
        std::vector<int> done(round % 7, 0);  // without a lock: each piece has its own element
        crew.run(done.size(), [&](size_t i) { ++done[i]; });
        for (const int each : done) wrong += each != 1;
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace chiasm::triton
