/** Signals and threads of ours. */
#pragma once

#include <pthread.h>
#include <signal.h>

namespace chiasm::base {

/** A thread that is created while one lives gets no signals of the process: the program's handlers run on the
 *  program's threads. Signals of faults are not blocked, because a blocked one ends the process without
 *  calling its handler. */
class SignalsBlocked final {
 public:
  SignalsBlocked() noexcept {
    sigset_t all;
    sigfillset(&all);
    for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGSYS}) sigdelset(&all, fault);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  SignalsBlocked(const SignalsBlocked&) = delete;
  SignalsBlocked& operator=(const SignalsBlocked&) = delete;
  ~SignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

 private:
  sigset_t before_;
};

}  // namespace chiasm::base
