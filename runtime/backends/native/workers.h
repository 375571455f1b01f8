/** The threads that native artifacts run on. */
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace chiasm::native {

/** A fixed number of threads for the whole process. Each call takes those that are idle, so that methods that
 *  run at the same time share the cores: there are never more threads at work than callers and workers
 *  together. */
class Workers final {
 public:
  using Body = void (*)(void* argument, int32_t index, int32_t count);

  /** `count` threads besides the callers', or as many as the system has left. */
  explicit Workers(int32_t count);
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /** Calls body(argument, i, n) at the same time on n threads, this one being 0, and returns when all have
   *  returned. n is 1 plus the number of idle workers that come at once, at most `others`. Must not throw. */
  void fork(Body body, void* argument, int32_t others);

  /** Calls body(argument, ...) on this thread and on at most `others` idle workers, also on those that come
   *  late, and returns when all have returned. For dynamically scheduled work: body must ignore its index and
   *  count, and late workers may find nothing to do. Must not throw. */
  void share(Body body, void* argument, int32_t others);

  size_t count() const { return workers_.size(); }

  /** The process's workers: created at the first call, with that call's count, and again in a child of fork.
   *  Never destroyed. */
  static Workers& instance(int32_t count);

 private:
  struct Job;
  struct Worker;
  class Offers;

  std::vector<Worker*> workers_;
  int32_t process_;  // a forked child has none of these threads
};

}  // namespace chiasm::native
