/** Threads that help an instance with a batch of several requests. */
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <mutex>
#include <thread>
#include <vector>

namespace chiasm::triton {

class Crew final {
 public:
  /** A crew of at most `size` threads, which start when there is work for them. */
  explicit Crew(size_t size) : size_(size) {}
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;
  ~Crew();

  /** Calls work(0) to work(count - 1), which throw nothing, on the calling thread and on idle ones of the
   *  crew; returns when all are done. From any thread. Throws std::bad_alloc before the first call, or not at
   *  all. */
  void run(size_t count, const std::function<void(size_t)>& work);

 private:
  struct Job {
    const std::function<void(size_t)>& work;
    size_t count, next = 0, done = 0;
  };

  void start();
  void help();
  /** Does one piece of the job; `lock` is open meanwhile. */
  void do_next(std::list<Job>::iterator job, std::unique_lock<std::mutex>& lock);

  const size_t size_;
  std::mutex mutex_;
  std::condition_variable work_there_, job_done_;
  std::list<Job> jobs_;  // those that are not done
  std::vector<std::thread> threads_;
  bool started_ = false, ending_ = false;
};

}  // namespace chiasm::triton
