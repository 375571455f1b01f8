// Interleaved timing: contenders take turns, so that a busy moment of the machine affects all of them;
// medians are compared.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace bench {

using Clock = std::chrono::steady_clock;

inline double microseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

// The resident memory of this process.
inline double resident_megabytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmRSS:", 0) == 0) return std::stod(line.substr(6)) / 1024;
  return 0;
}

inline double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

// Microseconds until the threads of another contender's pool sleep (in bench/wheel.py too).
constexpr double kPause = 20e3;

// The pause before a contender's turn, if threads are several.
inline void rest(int threads) {
  if (threads > 1) std::this_thread::sleep_for(std::chrono::duration<double, std::micro>(kPause));
}

// The median microseconds of each contender on so many threads, over rounds that take about `seconds` in
// total. Short calls are repeated within a turn. If threads are several, a pause before each turn lets those
// of the last contender's pool fall asleep; then calls that do not count warm up the machine and its caches
// for half that time, and the calls that count run equally long.
inline std::vector<double> interleaved(const std::vector<std::function<void()>>& contenders, int threads,
                                       double seconds = 2.0) {
  const double warm = threads > 1 ? kPause / 2 : 0;
  std::vector<int> repeats, warming;
  for (const auto& call : contenders) {
    for (int i = 0; i < 3; ++i) call();
    const auto start = Clock::now();
    call();
    const double taken = std::max(microseconds_since(start), 0.1);
    repeats.push_back(std::clamp(int(std::max(200.0, warm) / taken), 1, 2000));
    warming.push_back(taken < 1e6 ? int(std::ceil(warm / taken)) : 0);
  }
  std::vector<std::vector<double>> times(contenders.size());
  const auto start = Clock::now();
  while (times[0].size() < 7 || (microseconds_since(start) < seconds * 1e6 && times[0].size() < 1000)) {
    for (size_t i = 0; i < contenders.size(); ++i) {
      rest(threads);
      for (int n = 0; n < warming[i]; ++n) contenders[i]();
      const auto begin = Clock::now();
      for (int n = 0; n < repeats[i]; ++n) contenders[i]();
      times[i].push_back(microseconds_since(begin) / repeats[i]);
    }
  }
  std::vector<double> medians;
  for (auto& list : times) medians.push_back(median(list));
  return medians;
}

}  // namespace bench
