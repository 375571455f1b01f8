/** A piece of a test in a child process, which may die, hang or use up memory without harm to the test. */
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace chiasm::testing {

/** How a child ended. */
struct Ending {
  bool timed_out = false;
  int signal = 0;     // that ended it
  int code = 0;       // its exit code where none did
  std::string words;  // what it said, or the text of the exception that it ended by

  bool well() const { return !timed_out && signal == 0 && code == 0; }
  /** For messages: "signal 11 (Segmentation fault): ..." */
  std::string text() const;
};

/** Forks, runs `body` in the child, whose result is what it says, and ends the child after `limit` at the
 *  latest. Destructors of what the parent holds do not run in the child. An exception is the exit code 1. */
Ending in_child(std::chrono::milliseconds limit, const std::function<std::string()>& body);

}  // namespace chiasm::testing
