/** What every backend plug-in needs: errors with a code, the guard at the boundary, element sizes. */
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/backend.h"

namespace chiasm::plugin {

/** An error that knows its code. Anything else that is thrown is CHIASM_INTERNAL. */
class Error : public std::runtime_error {
 public:
  Error(chiasm_code code, const std::string& message) : std::runtime_error(message), code_(code) {}
  chiasm_code code() const noexcept { return code_; }

 private:
  chiasm_code code_;
};

inline int32_t report(chiasm_error_text* error, chiasm_code code, const char* message) noexcept {
  std::strncpy(error->text, message, sizeof(error->text) - 1);
  error->text[sizeof(error->text) - 1] = '\0';
  return code;
}

/** Runs `body` and turns whatever it throws into a code and a text: no exception may cross a plug-in's boundary. */
template <class Body>
int32_t guard(chiasm_error_text* error, Body&& body) noexcept {
  try {
    body();
    return CHIASM_OK;
  } catch (const Error& e) {
    return report(error, e.code(), e.what());
  } catch (const std::bad_alloc&) {
    return report(error, CHIASM_OUT_OF_MEMORY, "out of memory");
  } catch (const std::length_error&) {  // of a container that was asked for more than there can be
    return report(error, CHIASM_OUT_OF_MEMORY, "out of memory");
  } catch (const std::exception& e) {
    return report(error, CHIASM_INTERNAL, e.what());
  } catch (...) {
    return report(error, CHIASM_INTERNAL, "the engine threw something that is not a std::exception");
  }
}

inline size_t element_size(int32_t dtype) {
  switch (dtype) {
    case CHIASM_BOOL:
    case CHIASM_UINT8:
    case CHIASM_INT8: return 1;
    case CHIASM_INT16:
    case CHIASM_FLOAT16:
    case CHIASM_BFLOAT16: return 2;
    case CHIASM_INT32:
    case CHIASM_FLOAT32: return 4;
    case CHIASM_INT64:
    case CHIASM_FLOAT64: return 8;
    default: throw Error(CHIASM_INVALID_ARGUMENT, "unknown dtype " + std::to_string(dtype));
  }
}

inline size_t element_count(const chiasm_tensor& tensor) {
  size_t count = 1;
  for (int32_t i = 0; i < tensor.ndim; ++i) count *= static_cast<size_t>(tensor.shape[i]);
  return count;
}

/** A guess that costs no driver start (cuInit takes 100 ms and more): is there a device that this process may see? */
inline bool cuda_device_present() {
  const char* visible = std::getenv("CUDA_VISIBLE_DEVICES");
  if (visible != nullptr && (visible[0] == '\0' || visible[0] == '-')) return false;
  return access("/dev/nvidiactl", F_OK) == 0 || access("/dev/nvgpu", F_OK) == 0 || access("/dev/dxg", F_OK) == 0;
}

/** An anonymous file in memory. What is written cannot be changed once it is sealed. */
class MemoryFile {
 public:
  explicit MemoryFile(const char* name) : fd_(memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING)) {
    if (fd_ < 0) throw Error(CHIASM_IO_ERROR, std::string("memfd_create: ") + std::strerror(errno));
  }
  MemoryFile(MemoryFile&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  MemoryFile& operator=(MemoryFile&&) = delete;
  ~MemoryFile() {
    if (fd_ >= 0) close(fd_);
  }

  int fd() const { return fd_; }

  void write(const void* data, size_t size) {
    const char* p = static_cast<const char*>(data);
    while (size > 0) {
      const ssize_t n = ::write(fd_, p, std::min<size_t>(size, size_t{1} << 30));
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) {
        const chiasm_code code = errno == ENOMEM || errno == ENOSPC ? CHIASM_OUT_OF_MEMORY : CHIASM_IO_ERROR;
        throw Error(code, "write " + std::to_string(size) + " bytes to a memory file: " + std::strerror(errno));
      }
      p += n;
      size -= static_cast<size_t>(n);
    }
  }

  void seal() {
    if (fcntl(fd_, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL) != 0)
      throw Error(CHIASM_INTERNAL, std::string("seal memory file: ") + std::strerror(errno));
  }

  /** Who opens it reads the bytes. */
  std::string path() const {
    std::string path = "/proc/self/fd/" + std::to_string(fd_);
    if (access(path.c_str(), R_OK) != 0)
      throw Error(CHIASM_UNAVAILABLE, "code is loaded through " + path + ", which cannot be read (" + std::strerror(errno) + "): mount /proc");
    return path;
  }

 private:
  int fd_;
};

}  // namespace chiasm::plugin
