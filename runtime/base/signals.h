/** Signals and threads of ours. */
#pragma once

#include <pthread.h>
#include <signal.h>

namespace chiasm::base {

/** A thread that is made while one lives gets no signal of the process: the program's handlers run on the
 *  program's threads. Those of a fault stay, because a blocked one ends the process without its handler. */
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
