/** Helpers of every backend plug-in: the guard at the boundary, options, files in memory. */
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <string>
#include <thread>
#include <utility>

#include "base/dtype.h"
#include "base/error.h"
#include "chiasm/backend.h"

namespace chiasm::plugin {

using namespace base;

inline int32_t report(chiasm_error_text* error, chiasm_code code, const char* message) noexcept {
  std::strncpy(error->text, message, sizeof(error->text) - 1);
  error->text[sizeof(error->text) - 1] = '\0';
  return code;
}

/** Runs `body` and turns whatever it throws into a code and a text: no exception may cross a plug-in's
 *  boundary. */
template <class Body>
int32_t guard(chiasm_error_text* error, Body&& body) noexcept {
  try {
    body();
    return CHIASM_OK;
  } catch (...) {
    return report_current_exception(
        [error](chiasm_code code, const char* message) { return report(error, code, message); });
  }
}

/** The value of an option in a list of "key=value" texts that ends with NULL; `missing` if it is not
 *  there. */
inline std::string option(const char* const* options, const std::string& key,
                          const std::string& missing = "") {
  for (const char* const* o = options; o != nullptr && *o != nullptr; ++o) {
    if (std::strncmp(*o, key.c_str(), key.size()) == 0 && (*o)[key.size()] == '=') return *o + key.size() + 1;
  }
  return missing;
}

/** The same for an option that is 0 or 1. Throws Error (INVALID_ARGUMENT) for any other value. */
inline bool flag(const char* const* options, const std::string& key, bool missing) {
  const std::string value = option(options, key, missing ? "1" : "0");
  if (value != "0" && value != "1")
    throw Error(CHIASM_INVALID_ARGUMENT, "the option " + key + " is '" + value + "', expected 0 or 1");
  return value == "1";
}

/** An anonymous file in memory. Its content cannot be changed once it is sealed. */
class MemoryFile {
 public:
  explicit MemoryFile(const char* name) : fd_(memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING)) {
    if (fd_ >= 0) return;
    const int reason = errno;
    const std::string text = std::string("memfd_create: ") + std::strerror(reason);
    if (reason == ENOSYS || reason == EPERM || reason == EACCES)  // as in a sandbox: another backend may work
      throw Error(CHIASM_UNAVAILABLE,
                  "code is loaded through a file in memory, which is not allowed here (" + text + ")");
    throw Error(CHIASM_IO_ERROR, text);
  }
  MemoryFile(MemoryFile&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  MemoryFile& operator=(MemoryFile&&) = delete;
  ~MemoryFile() {
    if (fd_ >= 0) close(fd_);
  }

  int fd() const { return fd_; }

  void write(const void* data, size_t size) {
    // A write beyond the limit raises a signal, which ends the process.
    rlimit limit{};
    if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && size > limit.rlim_cur)
      throw Error(CHIASM_IO_ERROR, "a file in memory of " + std::to_string(size) +
                                       " bytes is larger than the process may write, " +
                                       std::to_string(limit.rlim_cur) +
                                       " bytes: raise RLIMIT_FSIZE (ulimit -f)");
    const char* p = static_cast<const char*>(data);
    while (size > 0) {
      const ssize_t n = ::write(fd_, p, std::min<size_t>(size, size_t{1} << 30));
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) {
        const chiasm_code code = errno == ENOMEM || errno == ENOSPC ? CHIASM_OUT_OF_MEMORY : CHIASM_IO_ERROR;
        throw Error(code,
                    "write " + std::to_string(size) + " bytes to a memory file: " + std::strerror(errno));
      }
      p += n;
      size -= static_cast<size_t>(n);
    }
  }

  /** Tries again on EBUSY: the kernel may hold a page for a moment, for instance while it moves pages. */
  void seal() {
    constexpr int kAllSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL;
    for (int tries = 1; fcntl(fd_, F_ADD_SEALS, kAllSeals) != 0; ++tries) {
      if (errno != EBUSY || tries == 100)
        throw Error(CHIASM_UNAVAILABLE, std::string("seal memory file: ") + std::strerror(errno));
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }

  /** Opening this path opens the file. */
  std::string path() const {
    std::string path = "/proc/self/fd/" + std::to_string(fd_);
    if (access(path.c_str(), R_OK) != 0)
      throw Error(CHIASM_UNAVAILABLE, "code is loaded through " + path + ", which cannot be read (" +
                                          std::strerror(errno) + "): mount /proc");
    return path;
  }

 private:
  int fd_;
};

}  // namespace chiasm::plugin
