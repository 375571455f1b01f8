// The functions of g++'s OpenMP library that compiled ops call, over threads that the host lends
// (chiasm_native_host::fork).
//
// So an op runs on the threads of its host: the native backend's workers, or the pool of an ONNX Runtime
// session. All threads of a region run at the same time, so a barrier is possible.
#include <atomic>
#include <utility>

#include "../spin.h"
#include "tensor.h"

namespace chiasm::artifact {
namespace {

// The threads in one parallel region.
struct Team {
  void (*body)(void*);
  void* argument;
  Run* run;
  std::atomic<int32_t> waiting{0};    // at the barrier
  std::atomic<uint32_t> barriers{0};  // passed so far
  std::atomic<uint32_t> singles{0};   // `single` blocks that some thread has taken
};

// This thread's place in its team. Plain data: a thread_local with a destructor would pin the library in the
// process.
struct Member {
  Team* team;
  int32_t index, count;
  uint32_t singles;  // `single` blocks that this thread has met
};

thread_local Member member;

void enter(void* argument, int32_t index, int32_t count) {
  auto* team = static_cast<Team*>(argument);
  const Member outer = std::exchange(member, Member{team, index, count, 0});
  team->body(team->argument);
  member = outer;
}

// Threads of a region reach a barrier within microseconds of each other, unless one has lost its core.
constexpr int kSpins = 4000;

}  // namespace

bool in_parallel_region() { return member.team != nullptr; }

Run* run_of_this_thread() { return member.team ? member.team->run : current_run(); }

}  // namespace chiasm::artifact

using namespace chiasm::artifact;

extern "C" {

int omp_get_thread_num() { return member.index; }
int omp_get_num_threads() { return member.team ? member.count : 1; }

// Compiled reductions allocate a partial result for each thread.
int omp_get_max_threads() {
  const Run* run = current_run();
  return run ? run->host->num_threads : 1;
}

// `threads` is 1 for a region whose `if` is false, else 0: the exporter compiles loops for the thread count
// at run time, and no region asks for a number of threads.
void GOMP_parallel(void (*body)(void*), void* argument, unsigned threads, unsigned) {
  Run* const run = run_of_this_thread();
  Team team{body, argument, run};
  if (member.team || !run || threads == 1 || run->host->num_threads == 1) {
    enter(&team, 0, 1);
  } else {
    run->host->fork(run->host->context, enter, &team);
  }
}

void GOMP_barrier() {
  if (!member.team || member.count == 1) return;
  Team& team = *member.team;
  const uint32_t passed = team.barriers.load(std::memory_order_acquire);
  if (team.waiting.fetch_add(1, std::memory_order_acq_rel) + 1 == member.count) {
    team.waiting.store(0, std::memory_order_relaxed);
    team.barriers.store(passed + 1, std::memory_order_release);
    team.barriers.notify_all();
    return;
  }
  for (int i = 0; i < kSpins; ++i) {
    if (team.barriers.load(std::memory_order_acquire) != passed) return;
    chiasm::relax();
  }
  team.barriers.wait(passed, std::memory_order_acquire);
}

// True in one thread of the team for each `single` block: the first one to reach it.
bool GOMP_single_start() {
  if (!member.team) return true;
  uint32_t met = member.singles++;
  return member.team->singles.compare_exchange_strong(met, met + 1, std::memory_order_acq_rel);
}

}  // extern "C"
