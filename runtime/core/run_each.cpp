// Checks all runs of a call, and that no output shares memory with a tensor of another run; then a few
// threads take the runs from a queue.
#include "core/run_each.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <new>
#include <optional>
#include <system_error>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "base/signals.h"
#include "core/gaps.h"
#include "core/status.h"
#include "core/threads.h"

namespace chiasm::core {
namespace {

/** The memory of a tensor of a run, or a part of it. */
struct Memory {
  Rows rows;
  const chiasm_tensor* tensor;
  size_t run;
  bool is_output;
};

/** Whether two share a byte, where `b` begins within `a` or its gaps. If their pitches differ, the one with
 *  the smaller pitch counts as one row, with its gaps. */
bool share(const Rows& a, const Rows& b) {
  const size_t pitch = std::max(a.pitch, b.pitch);
  const auto length = [pitch](const Rows& rows) { return rows.pitch == pitch ? rows.row : rows.bytes; };
  // from the begin of a row of `a` to that of the next row of `b`
  const size_t offset = (b.begin - a.begin) % pitch;
  return offset < length(a) || offset + length(b) > pitch;
}

/** An output, and the memory of another run that it shares. */
using Conflict = std::pair<Memory, Memory>;

/** The first conflict in memory. Sorts `all`; then it takes as many steps as pairs of which one begins within
 *  the other, and these are few unless regions of one image lie side by side. */
std::optional<Conflict> find_conflict(std::vector<Memory>& all) {
  std::sort(all.begin(), all.end(), [](const Memory& a, const Memory& b) {
    return std::tie(a.rows.begin, a.run) < std::tie(b.rows.begin, b.run);
  });
  std::vector<const Memory*> inputs, outputs;  // those before this one in memory that may reach it
  const auto shared = [](std::vector<const Memory*>& before, const Memory& memory) -> const Memory* {
    const uintptr_t begin = memory.rows.begin;
    const auto ended = [begin](const Memory* one) { return one->rows.begin + one->rows.bytes <= begin; };
    before.erase(std::remove_if(before.begin(), before.end(), ended), before.end());
    const auto found = std::find_if(before.begin(), before.end(), [&](const Memory* one) {
      return one->run != memory.run && share(one->rows, memory.rows);
    });
    return found == before.end() ? nullptr : *found;
  };
  for (const Memory& memory : all) {
    const Memory* other = shared(outputs, memory);
    if (other == nullptr && memory.is_output) other = shared(inputs, memory);
    if (other != nullptr) return memory.is_output ? Conflict(memory, *other) : Conflict(*other, memory);
    (memory.is_output ? outputs : inputs).push_back(&memory);
  }
  return std::nullopt;
}

/** Throws if an output shares memory with a tensor of another run. `all` has each tensor as one row. */
void check_apart(std::vector<Memory>& all) {
  if (!find_conflict(all)) return;
  // Gaps counted as memory, and regions of one image lie in each other's gaps. Now they do not count.
  std::vector<Memory> parts;
  for (const Memory& whole : all) {
    for (const Rows& rows : rows_of(*whole.tensor))
      parts.push_back({rows, whole.tensor, whole.run, whole.is_output});
  }
  const std::optional<Conflict> conflict = find_conflict(parts);
  if (!conflict) return;
  const auto& [output, other] = *conflict;
  fail(CHIASM_INVALID_ARGUMENT,
       "run " + std::to_string(output.run) + ": the memory of an output overlaps that of an " +
           (other.is_output ? "output" : "input") + " of run " + std::to_string(other.run));
}

/** Throws a run's error again, with the run's number. */
[[noreturn]] void fail_in(size_t run, const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const Error& e) {
    fail(e.code(), "run " + std::to_string(run) + ": " + e.what());
  } catch (const std::bad_alloc&) {
    fail(CHIASM_OUT_OF_MEMORY, "run " + std::to_string(run) + ": out of memory");
  }
}

/** The runs of a call. Each thread takes the next run until none is left. */
class Queue {
 public:
  explicit Queue(size_t runs) : runs_(runs) {}

  template <class Run>
  void work(const Run& run) {
    for (size_t i = next_.fetch_add(1); i < runs_; i = next_.fetch_add(1)) {
      try {
        run(i);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (i < failed_) {
          failed_ = i;
          error_ = std::current_exception();
        }
      }
    }
  }

  void check() const {
    if (error_ != nullptr) fail_in(failed_, error_);
  }

 private:
  const size_t runs_;
  std::atomic<size_t> next_{0};
  std::mutex mutex_;
  size_t failed_ = SIZE_MAX;
  std::exception_ptr error_;
};

}  // namespace

void run_each(const Method& method, size_t runs, const chiasm_tensor* inputs, size_t input_count,
              const chiasm_tensor* outputs, size_t output_count, const chiasm_run_options* options) {
  const auto of_run = [](const chiasm_tensor* all, size_t run, size_t count) {
    if (all == nullptr || count == 0) return all;
    const chiasm_tensor* const first = &tensor_at(all, run * count);
    if (first->struct_size != all->struct_size)
      fail(CHIASM_INVALID_ARGUMENT, "its first tensor's struct_size is " +
                                        std::to_string(first->struct_size) + ", that of run 0 " +
                                        std::to_string(all->struct_size));
    return first;
  };
  check_run_options(options);  // even if there are no runs
  std::vector<Memory> memory;
  const auto note = [&](const chiasm_tensor& tensor, size_t run, bool is_output) {
    const auto begin = reinterpret_cast<uintptr_t>(tensor.data);
    const size_t bytes = bytes_spanned(tensor);
    if (bytes > 0) memory.push_back({{begin, bytes, bytes, bytes}, &tensor, run, is_output});
  };
  for (size_t run = 0; run < runs; ++run) {
    Call call;
    try {
      method.check(of_run(inputs, run, input_count), input_count, of_run(outputs, run, output_count),
                   output_count, options, call);
    } catch (const Error&) {
      fail_in(run, std::current_exception());
    }
    for (size_t i = 0; i < input_count; ++i) note(tensor_at(inputs, run * input_count + i), run, false);
    for (size_t i = 0; i < output_count; ++i) note(tensor_at(outputs, run * output_count + i), run, true);
  }
  check_apart(memory);

  Queue queue(runs);
  const auto work = [&] {
    queue.work([&](size_t run) {
      method.run_into(of_run(inputs, run, input_count), input_count, of_run(outputs, run, output_count),
                      output_count, options);
    });
  };
  std::vector<std::thread> others;
  const size_t at_once = std::min(runs, method.runs_at_once());
  try {
    const SignalsBlocked blocked;
    others.reserve(at_once);
    while (others.size() + 1 < at_once) others.emplace_back(work);
  } catch (const std::system_error&) {
    // The process can create no more threads: the existing ones do the work.
  } catch (const std::bad_alloc&) {
    // No memory is left for another thread: likewise.
  }
  work();
  for (std::thread& other : others) other.join();
  queue.check();
}

}  // namespace chiasm::core
