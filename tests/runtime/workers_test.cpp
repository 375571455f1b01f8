/** The native backend's threads. */
#include "backends/native/workers.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <numeric>
#include <thread>
#include <vector>

#include "base/fork.h"

namespace chiasm::native {
namespace {

constexpr int32_t kAll = 64;  // more than there are

/** The indices that were called, and the counts. */
struct Calls {
  std::vector<std::atomic<int>> made = std::vector<std::atomic<int>>(64);
  std::atomic<int32_t> count{0}, present{0};
  std::atomic<bool> together{true};

  static void body(void* self, int32_t index, int32_t count) {
    auto& calls = *static_cast<Calls*>(self);
    calls.count = count;
    ++calls.made[static_cast<size_t>(index)];
    // All members of a team are present at the same time: each waits for the others.
    ++calls.present;
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (calls.present < count) {
      if (std::chrono::steady_clock::now() > limit) {
        calls.together = false;
        return;
      }
      std::this_thread::yield();
    }
  }
};

TEST(Workers, EachIndexIsCalledOnceAndAllAtTheSameTime) {
  // its threads never end; static, so that it is not reported as a leak
  static Workers& workers = *new Workers(3);
  for (int round = 0; round < 200; ++round) {
    Calls calls;
    workers.fork(Calls::body, &calls, kAll);
    ASSERT_TRUE(calls.together);
    // A worker that is still returning from the last round takes no part, nor does one that comes too late.
    ASSERT_GE(calls.count, 1);
    ASSERT_LE(calls.count, 4);
    for (int32_t i = 0; i < 64; ++i) ASSERT_EQ(calls.made[static_cast<size_t>(i)], i < calls.count ? 1 : 0);
  }
}

TEST(Workers, AnIdleOneIsTakenAgainAfterItFellAsleep) {
  static Workers& workers = *new Workers(1);
  // On a busy machine, a worker may come too late and take no part, but not every time.
  int complete = 0;
  for (int round = 0; round < 1000 && complete < 3; ++round) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    Calls calls;
    workers.fork(Calls::body, &calls, kAll);
    if (calls.count == 2) ++complete;
  }
  EXPECT_EQ(complete, 3);
}

TEST(Workers, SharedPiecesAreEachDoneOnceAlsoByThoseThatComeLate) {
  static Workers& workers = *new Workers(3);
  struct Work {
    std::atomic<int> next{0}, callers{0};
    std::vector<std::atomic<int>> done = std::vector<std::atomic<int>>(1000);
  };
  const auto body = [](void* argument, int32_t, int32_t) {
    auto& work = *static_cast<Work*>(argument);
    ++work.callers;
    for (int piece; (piece = work.next++) < 1000;) {
      ++work.done[static_cast<size_t>(piece)];
      // No worker does all alone: the pieces last until another worker, which may have been asleep, has
      // joined.
      const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
      while (piece == 999 && work.callers < 2 && std::chrono::steady_clock::now() < limit)
        std::this_thread::yield();
    }
  };
  for (int round = 0; round < 50; ++round) {
    if (round % 10 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    Work work;
    workers.share(body, &work, kAll);
    EXPECT_GE(work.callers, 2);
    EXPECT_LE(work.callers, 4);
    for (const auto& count : work.done) ASSERT_EQ(count, 1);
  }
}

TEST(Workers, CallersAtTheSameTimeShareThem) {
  static Workers& workers = *new Workers(3);
  std::atomic<int> at_work{0}, most{0}, wrong{0};
  struct Work {
    std::atomic<int>&at_work, &most;
    std::atomic<int64_t> sum{0};
  };
  const auto body = [](void* argument, int32_t index, int32_t count) {
    auto& work = *static_cast<Work*>(argument);
    const int now = ++work.at_work;
    for (int before = work.most; before < now && !work.most.compare_exchange_weak(before, now);) {}
    for (int64_t i = index; i < 1000; i += count) work.sum += i;
    --work.at_work;
  };
  std::vector<std::thread> callers;
  for (int c = 0; c < 8; ++c) {
    callers.emplace_back([&] {
      for (int round = 0; round < 300; ++round) {
        Work work{at_work, most};
        workers.fork(body, &work, kAll);
        if (work.sum != 999 * 1000 / 2) ++wrong;
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_LE(most, 8 + 3);
}

TEST(Workers, AForkedChildGoesOnAlone) {
  static Workers& workers = *new Workers(2);
  const pid_t child = ::fork();
  if (child == 0) {
    Calls calls;
    workers.fork(Calls::body, &calls, kAll);
    ::_exit(calls.count == 1 && calls.made[0] == 1 ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

TEST(Workers, SignalsOfTheProcessDoNotComeToThem) {
  static Workers& workers = *new Workers(3);
  struct Seen {
    std::atomic<int> workers{0}, open{0};
  } seen;
  const auto body = [](void* argument, int32_t index, int32_t) {
    auto& seen = *static_cast<Seen*>(argument);
    if (index == 0) return;
    sigset_t blocked;
    ::pthread_sigmask(SIG_SETMASK, nullptr, &blocked);
    ++seen.workers;
    if (sigismember(&blocked, SIGUSR1) != 1 || sigismember(&blocked, SIGSEGV) != 0) ++seen.open;
  };
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (seen.workers == 0 && std::chrono::steady_clock::now() < limit) workers.fork(body, &seen, kAll);
  EXPECT_GT(seen.workers, 0);
  EXPECT_EQ(seen.open, 0);
  sigset_t own;
  ::pthread_sigmask(SIG_SETMASK, nullptr, &own);
  EXPECT_EQ(sigismember(&own, SIGUSR1), 0);
}

#ifndef __SANITIZE_THREAD__  // in its child processes, no threads can be created
TEST(Workers, AForkedChildHasTheProcessesWorkersAnew) {
  const Workers& workers = Workers::instance(2);
  ASSERT_EQ(workers.count(), 2u);
  const pid_t child = ::fork();
  if (child == 0) {
    const Workers& own = Workers::instance(2);
    ::_exit(&own != &workers && own.count() == 2 ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}
#endif

/** Without the gate, most children would find the mutex locked for ever. */
TEST(ForkGate, AChildFindsFreeWhatIsLockedInside) {
  static std::mutex& mutex = *new std::mutex;
  std::atomic<bool> stop{false};
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i) {
    threads.emplace_back([&stop] {
      while (!stop) {
        const base::ForkGate::Passage passage;
        const std::lock_guard<std::mutex> lock(mutex);
        std::this_thread::sleep_for(std::chrono::microseconds(100));
      }
    });
  }
  int taken = 0;
  for (int round = 0; round < 50; ++round) {
    const pid_t child = ::fork();
    if (child == 0) ::_exit(mutex.try_lock() ? 0 : 1);
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) ++taken;
  }
  stop = true;
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(taken, 0);
}

/** An engine's threads, each of which wakes the next one after a call has ended: without the wait, most
 *  children would find the engine's mutex locked. */
TEST(ForkGate, AChildFindsFreeWhatAnEnginesThreadsLockAfterACall) {
  static std::mutex& engine = *new std::mutex;
  struct Turn {
    std::mutex mutex;
    std::condition_variable changed;
    int due = 0;
    bool over = false;

    void come(bool last) {
      const std::lock_guard lock(mutex);
      ++due;
      over = last;
      changed.notify_one();
    }
  };
  std::array<Turn, 3> turns;
  std::vector<std::thread> threads;
  for (size_t i = 0; i < turns.size(); ++i) {
    threads.emplace_back([&turns, i] {
      const base::ForkGate::Worker worker;
      for (int done = 0;; ++done) {
        std::unique_lock wait(turns[i].mutex);
        turns[i].changed.wait(wait, [&] { return turns[i].due > done; });
        const bool over = turns[i].over;
        wait.unlock();
        if (!over) {
          const std::lock_guard lock(engine);
          const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(300);
          while (std::chrono::steady_clock::now() < end) {}
        }
        if (i + 1 < turns.size()) turns[i + 1].come(over);
        if (over) return;
      }
    });
  }
  int taken = 0;
  for (int round = 0; round < 50; ++round) {
    {
      const base::ForkGate::Passage passage;
      turns[0].come(false);
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
    const pid_t child = ::fork();
    if (child == 0) ::_exit(engine.try_lock() ? 0 : 1);
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) ++taken;
  }
  turns[0].come(true);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(taken, 0);
}

}  // namespace
}  // namespace chiasm::native
