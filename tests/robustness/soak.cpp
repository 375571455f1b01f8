/** Many threads that call in every way for a long time:
 *
 *      soak SECONDS [WAY...]      64 threads; the ways are those of ways_to_call(), by default all
 *
 *  Each thread draws methods and sizes at random, reloads some, makes some wrong calls, and compares every
 *  result with the first one bit for bit. It prints a line of progress every 10 s. Fails at the first wrong
 *  result, and if memory, threads or files grow. */
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <random>
#include <thread>

#include "calls.h"

namespace {

using namespace chiasm::testing;
using Clock = std::chrono::steady_clock;

constexpr int kThreads = 64;
/** The allowed growth of the process after warming up: the pools keep 256 MB each, and engines an arena for
 *  each size. */
constexpr int64_t kGrowthKb = 256 << 10;

struct Work {
  std::string way, bundle, method;
  Callable call;
  std::vector<Inputs> inputs;
  std::vector<std::string> answers;
  std::vector<chiasm::Tensor> wrong;  // the inputs of a call that must be rejected
};

/** Microseconds, in steps of a tenth. */
class Latencies {
 public:
  void add(double microseconds) {
    const int step = microseconds <= 1 ? 0 : static_cast<int>(std::log(microseconds) / kStep);
    ++counts_[static_cast<size_t>(std::min(step, kSteps - 1))];
  }
  double quantile(double share) const {
    int64_t all = 0, below = 0;
    for (const auto& count : counts_) all += count;
    for (int i = 0; i < kSteps; ++i) {
      below += counts_[static_cast<size_t>(i)];
      if (below > 0 && static_cast<double>(below) >= share * static_cast<double>(all))
        return std::exp(kStep * (i + 1));
    }
    return 0;
  }

 private:
  static constexpr int kSteps = 200;
  static constexpr double kStep = 0.0953;  // log(1.1)
  std::array<std::atomic<int64_t>, kSteps> counts_{};
};

struct Totals {
  std::atomic<int64_t> calls{0}, loads{0}, refused{0};
  std::atomic<bool> stop{false};
  Latencies latencies;
  std::mutex mutex;
  std::string trouble;

  void fail(const std::string& text) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (trouble.empty()) trouble = text;
    stop = true;
  }
};

std::vector<Work> prepare(const std::vector<std::string>& ways) {
  std::vector<Work> all;
  for (const char* name : {"filters.sobel", "pipelines.edges", "color.rgb_to_grayscale"}) {
    const std::string bundle = bundle_path(name);
    for (const chiasm::MethodInfo& method : chiasm::Bundle::open(bundle).methods()) {
      for (const std::string& way : ways) {
        Work work{way, bundle, method.name, load(way, bundle, method.name), {}, {}, {}};
        uint64_t seed = 0;
        for (const int64_t largest : {16, 40, 100, 300})
          work.inputs.push_back(make_inputs(method, ++seed, largest));
        for (const Inputs& inputs : work.inputs) work.answers.push_back(work.call(inputs));
        work.wrong = work.inputs[0].tensors;
        const chiasm::Tensor& first = work.wrong[0];
        work.wrong[0] = chiasm::Tensor(first.data(), first.dtype(), chiasm::Shape{1});  // another rank
        all.push_back(std::move(work));
      }
    }
  }
  return all;
}

void call_wrongly(const Work& work, Totals& totals) {
  Inputs inputs;
  inputs.tensors = work.wrong;
  try {
    work.call(inputs);
    totals.fail(work.way + ": a call with a wrong shape was not refused");
  } catch (const std::exception&) {
    ++totals.refused;
  }
}

void run(const std::vector<Work>& all, uint64_t seed, Totals& totals) {
  std::mt19937_64 random(seed);
  const auto one_of = [&random](size_t count) {
    return std::uniform_int_distribution<size_t>(0, count - 1)(random);
  };
  while (!totals.stop) {
    const Work& work = all[one_of(all.size())];
    const size_t i = one_of(work.inputs.size());
    try {
      if (one_of(20) == 0) call_wrongly(work, totals);
      const bool anew = one_of(100) == 0;
      const Callable call = anew ? load(work.way, work.bundle, work.method) : work.call;
      if (anew) ++totals.loads;
      const auto begun = Clock::now();
      const std::string answer = call(work.inputs[i]);
      totals.latencies.add(std::chrono::duration<double, std::micro>(Clock::now() - begun).count());
      ++totals.calls;
      if (answer != work.answers[i])
        totals.fail(work.way + ": " + work.bundle + " " + work.method + ", inputs " + std::to_string(i) +
                    ": another answer");
    } catch (const std::exception& error) {
      totals.fail(work.way + ": " + work.bundle + " " + work.method + ": " + error.what());
    }
  }
}

void say(double seconds, const Totals& totals, const Holdings& now) {
  std::printf("soak %6.0f s  %9lld calls (%.0f/s), %lld loads, %lld refused; p50 %.2f ms, p99 %.1f ms; %s\n",
              seconds, static_cast<long long>(totals.calls), static_cast<double>(totals.calls) / seconds,
              static_cast<long long>(totals.loads), static_cast<long long>(totals.refused),
              totals.latencies.quantile(0.5) / 1e3, totals.latencies.quantile(0.99) / 1e3,
              now.text().c_str());
  std::fflush(stdout);
}

int soak(double seconds, const std::vector<std::string>& ways) {
  const std::vector<Work> all = prepare(ways);
  std::printf("soak: %zu methods x 4 sizes, %d threads, %.0f s\n", all.size(), kThreads, seconds);
  Totals totals;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t)
    threads.emplace_back([&, t] { run(all, static_cast<uint64_t>(t) + 1, totals); });
  const auto begun = Clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - begun).count(); };
  Holdings warm, most;
  bool is_warm = false;
  double next = std::min(10.0, seconds / 4);
  while (!totals.stop && elapsed() < seconds) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (elapsed() < next) continue;
    next += std::min(10.0, seconds / 4);
    const Holdings now = Holdings::now();
    say(elapsed(), totals, now);
    most.resident_kb = std::max(most.resident_kb, now.resident_kb);
    most.threads = std::max(most.threads, now.threads);
    if (!is_warm && elapsed() >= seconds / 2 - 1) {
      warm = now;
      is_warm = true;
    }
  }
  totals.stop = true;
  for (std::thread& thread : threads) thread.join();
  const Holdings last = Holdings::now();
  say(elapsed(), totals, last);
  std::printf(
      "soak: in the second half the memory grew by %lld MB (allowed: %lld), the most was %lld MB and %lld "
      "threads\n",
      static_cast<long long>((most.resident_kb - warm.resident_kb) / 1024),
      static_cast<long long>(kGrowthKb / 1024), static_cast<long long>(most.resident_kb / 1024),
      static_cast<long long>(most.threads));
  // A calling thread opens files while it loads. Now that all threads have ended, there are at most as many
  // open files as in the middle.
  if (most.resident_kb > warm.resident_kb + kGrowthKb) totals.fail("the memory grows");
  if (most.threads > warm.threads + 8) totals.fail("the number of threads grows");
  if (last.files > warm.files) totals.fail("the number of open files grows");
  if (!totals.trouble.empty()) std::printf("soak: FAILED: %s\n", totals.trouble.c_str());
  return totals.trouble.empty() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2 || std::atof(argv[1]) <= 0) {
    std::fprintf(stderr, "usage: soak SECONDS [WAY...]\n");
    return 2;
  }
  std::vector<std::string> ways(argv + 2, argv + argc);
  if (ways.empty()) ways = ways_to_call();
  return soak(std::atof(argv[1]), ways);
} catch (const std::exception& error) {
  std::fprintf(stderr, "soak: %s\n", error.what());
  return 1;
}
