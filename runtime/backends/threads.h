/** How many threads an engine may be told to make. Engines that cannot make theirs hang, or end the process. */
#pragma once

#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace chiasm::plugin {

/** How many threads more than those that are there the process may have now, up to `wanted`: they are made, and end at once. */
inline int32_t threads_left(int32_t wanted) {
  std::vector<std::thread> threads;
  std::mutex mutex;
  std::unique_lock<std::mutex> all_are_there(mutex);
  try {
    threads.reserve(static_cast<size_t>(wanted));
    while (static_cast<int32_t>(threads.size()) < wanted) threads.emplace_back([&mutex] { const std::lock_guard<std::mutex> wait(mutex); });
  } catch (const std::exception&) {  // no more threads, or no memory for one
  }
  const auto count = static_cast<int32_t>(threads.size());
  all_are_there.unlock();
  for (std::thread& thread : threads) thread.join();
  return count;
}

}  // namespace chiasm::plugin
