#include "child.h"

#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace chiasm::testing {
namespace {

void write_all(int fd, const std::string& text) {
  for (size_t done = 0; done < text.size();) {
    const ssize_t n = ::write(fd, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return;
    done += static_cast<size_t>(n);
  }
}

/** Reads until the other side ends. False if `until` came first. */
bool read_all(int fd, std::chrono::steady_clock::time_point until, std::string& text) {
  char buffer[4096];
  for (;;) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(until - std::chrono::steady_clock::now())
            .count();
    pollfd waiting{fd, POLLIN, 0};
    const int ready = left <= 0 ? 0 : ::poll(&waiting, 1, static_cast<int>(left));
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    const ssize_t n = ::read(fd, buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return true;
    text.append(buffer, static_cast<size_t>(n));
  }
}

}  // namespace

std::string Ending::text() const {
  if (timed_out) return "did not end in time" + (words.empty() ? "" : ": " + words);
  if (signal != 0)
    return "signal " + std::to_string(signal) + " (" + ::strsignal(signal) + ")" +
           (words.empty() ? "" : ": " + words);
  return code == 0 ? words : "exit code " + std::to_string(code) + ": " + words;
}

Ending in_child(std::chrono::milliseconds limit, const std::function<std::string()>& body) {
  int ends[2];
  if (::pipe(ends) != 0) throw std::runtime_error(std::string("pipe: ") + std::strerror(errno));
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error(std::string("fork: ") + std::strerror(errno));
  if (child == 0) {
    ::close(ends[0]);
    ::setpgid(0, 0);
    int code = 0;
    try {
      write_all(ends[1], body());
    } catch (const std::exception& error) {
      write_all(ends[1], error.what());
      code = 1;
    }
    ::_exit(code);
  }
  ::close(ends[1]);
  Ending ending;
  ending.timed_out = !read_all(ends[0], std::chrono::steady_clock::now() + limit, ending.words);
  ::close(ends[0]);
  if (ending.timed_out) ::kill(-child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {}
  if (WIFSIGNALED(status) && !ending.timed_out) ending.signal = WTERMSIG(status);
  if (WIFEXITED(status)) ending.code = WEXITSTATUS(status);
  return ending;
}

}  // namespace chiasm::testing
