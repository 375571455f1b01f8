// Interleaved timing: contenders take turns, so that a busy moment of the machine affects all of them;
// medians are compared.
#pragma once

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <string>
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

// The median microseconds of each contender over rounds that take about `seconds` in total. Short calls are
// repeated within a turn.
inline std::vector<double> interleaved(const std::vector<std::function<void()>>& contenders,
                                       double seconds = 2.0) {
  std::vector<int> repeats;
  for (const auto& call : contenders) {
    for (int i = 0; i < 3; ++i) call();
    const auto start = Clock::now();
    call();
    repeats.push_back(std::clamp(int(200.0 / std::max(microseconds_since(start), 0.1)), 1, 2000));
  }
  std::vector<std::vector<double>> times(contenders.size());
  const auto start = Clock::now();
  while (times[0].size() < 7 || (microseconds_since(start) < seconds * 1e6 && times[0].size() < 1000)) {
    for (size_t i = 0; i < contenders.size(); ++i) {
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
