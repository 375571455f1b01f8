/** A part of a test in a child process, which may die, hang or exhaust memory without harm to the test. */
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace chiasm::testing {

/** How a child ended. */
struct Ending {
  bool timed_out = false;
  int signal = 0;     // the signal that ended it
  int code = 0;       // its exit code without a signal
  std::string words;  // its result, or the text of the exception that ended it

  bool well() const { return !timed_out && signal == 0 && code == 0; }
  /** For messages: "signal 11 (Segmentation fault): ..." */
  std::string text() const;
};

/** Forks, runs `body` in the child, returns its result in `words`, and ends the child after `limit` at the
 *  latest. Destructors of the parent's objects do not run in the child. Exceptions give the exit code 1. */
Ending in_child(std::chrono::milliseconds limit, const std::function<std::string()>& body);

}  // namespace chiasm::testing
