/** Checks how many threads and how much memory the process can still get: engines that cannot create their
 *  threads, or allocate their tables, hang or end the process. */
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "backends/plugin.h"
#include "base/room.h"
#include "base/signals.h"

namespace chiasm::plugin {

/** How many more threads, up to `wanted`, the process can create now. It creates them to find out; they end
 *  at once. */
inline int32_t threads_left(int32_t wanted) {
  std::vector<std::thread> threads;
  std::mutex mutex;
  std::unique_lock<std::mutex> all_are_there(mutex);
  const SignalsBlocked blocked;  // in the new threads
  try {
    threads.reserve(static_cast<size_t>(wanted));
    while (static_cast<int32_t>(threads.size()) < wanted)
      threads.emplace_back([&mutex] { const std::lock_guard<std::mutex> wait(mutex); });
  } catch (const std::exception&) {  // no more threads, or no memory for one
  }
  const auto count = static_cast<int32_t>(threads.size());
  all_are_there.unlock();
  for (std::thread& thread : threads) thread.join();
  return count;
}

/** The bytes that glibc maps for a moment at a thread's first allocation: twice the size of an arena. It
 *  keeps the aligned half. */
inline constexpr size_t kArenaBytes = size_t{128} << 20;

/** Throws CHIASM_OUT_OF_MEMORY, naming `purpose`, unless the process may have `bytes` more now. */
inline void require_memory(size_t bytes, const std::string& purpose) {
  if (!has_room(bytes))
    throw Error(CHIASM_OUT_OF_MEMORY,
                purpose + " needs " + std::to_string(bytes) + " bytes, which the process may not have");
}

}  // namespace chiasm::plugin
