#include "core/file.h"

#include <fcntl.h>
#include <nettle/sha2.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/status.h"

namespace chiasm::core {
namespace {

class Descriptor final {
 public:
  explicit Descriptor(const std::string& path) : value_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  int value() const { return value_; }

 private:
  int value_;
};

}  // namespace

Bytes read_file(const std::string& path, uint64_t limit) {
  const Descriptor file(path);
  if (file.value() < 0) {
    fail(errno == ENOENT || errno == ENOTDIR ? CHIASM_NOT_FOUND : CHIASM_CORRUPT, path + ": " + std::strerror(errno));
  }
  struct stat info {};
  if (::fstat(file.value(), &info) != 0) fail(CHIASM_CORRUPT, path + ": " + std::strerror(errno));
  if (!S_ISREG(info.st_mode)) fail(CHIASM_CORRUPT, path + ": not a regular file");
  const auto size = static_cast<uint64_t>(info.st_size);
  if (size > limit) {
    fail(CHIASM_CORRUPT, path + ": has " + std::to_string(size) + " bytes, expected at most " + std::to_string(limit));
  }
  Bytes bytes(size);
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got = ::read(file.value(), bytes.data() + done, bytes.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(CHIASM_CORRUPT, path + ": " + std::strerror(errno));
    if (got == 0) break;  // cut while we read; the size check finds it
    done += static_cast<size_t>(got);
  }
  bytes.resize(done);
  return bytes;
}

std::string sha256(const void* data, size_t size) {
  sha256_ctx context;
  sha256_init(&context);
  sha256_update(&context, size, static_cast<const uint8_t*>(data));
  uint8_t digest[SHA256_DIGEST_SIZE];
  sha256_digest(&context, sizeof digest, digest);
  static const char* const kHex = "0123456789abcdef";
  std::string text;
  text.reserve(2 * sizeof digest);
  for (const uint8_t byte : digest) {
    text += kHex[byte >> 4];
    text += kHex[byte & 15];
  }
  return text;
}

Bytes read_checked(const std::string& path, uint64_t size, std::string_view expected_sha256) {
  Bytes bytes = read_file(path, size);
  if (bytes.size() < size) {
    fail(CHIASM_CORRUPT, path + ": truncated: has " + std::to_string(bytes.size()) + " bytes, the manifest says " +
                             std::to_string(size));
  }
  const std::string actual = sha256(bytes.data(), bytes.size());
  if (actual != expected_sha256) {
    fail(CHIASM_CORRUPT, path + ": changed since the bundle was made: its sha256 is " + actual + ", the manifest says " +
                             std::string(expected_sha256));
  }
  return bytes;
}

}  // namespace chiasm::core
