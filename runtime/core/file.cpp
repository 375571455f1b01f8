// Reads files of a bundle relative to its open folder, so that no link leads out of it, and compares their
// hashes.
#include "core/file.h"

#include <dirent.h>
#include <fcntl.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>

#include "core/status.h"

namespace chiasm::core {
namespace {

class Descriptor final {
 public:
  explicit Descriptor(int value) : value_(value) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  int value() const { return value_; }

 private:
  int value_;
};

/** Throws the error in errno, with the file's name. */
[[noreturn]] void fail_by_system(const std::string& path) {
  const int reason = errno;
  const chiasm_code code = reason == ENOENT || reason == ENOTDIR ? CHIASM_NOT_FOUND
                           : reason == ENOMEM                    ? CHIASM_OUT_OF_MEMORY
                                                                 : CHIASM_IO_ERROR;
  std::string advice;
  if (reason == EMFILE) advice = ": close some, or raise the limit (ulimit -n)";
  if (reason == EACCES || reason == EPERM) advice = ": this process must be allowed to read it";
  fail(code, path + ": " + std::strerror(reason) + advice);
}

Bytes read_whole(int descriptor, const std::string& path, uint64_t limit) {
  const Descriptor file(descriptor);
  if (file.value() < 0) fail_by_system(path);
  struct stat info {};
  if (::fstat(file.value(), &info) != 0) fail_by_system(path);
  if (!S_ISREG(info.st_mode)) fail(CHIASM_CORRUPT, path + ": not a regular file");
  const auto size = static_cast<uint64_t>(info.st_size);
  if (size > limit) {
    fail(CHIASM_CORRUPT,
         path + ": has " + std::to_string(size) + " bytes, expected at most " + std::to_string(limit));
  }
  Bytes bytes = make_bytes(size, path);
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got = ::read(file.value(), bytes.data() + done, bytes.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail_by_system(path);
    if (got == 0) break;  // truncated while we read; the size check reports it
    done += static_cast<size_t>(got);
  }
  bytes.resize(done);
  return bytes;
}

/** The path of an open file by /proc; "" if unknown. */
std::string place_of(int descriptor) {
  char place[PATH_MAX];
  const ssize_t size =
      ::readlink(("/proc/self/fd/" + std::to_string(descriptor)).c_str(), place, sizeof place);
  return size > 0 && size < PATH_MAX ? std::string(place, static_cast<size_t>(size)) : "";
}

}  // namespace

Bytes make_bytes(uint64_t size, const std::string& what) {
  try {
    return Bytes(size);
  } catch (const std::bad_alloc&) {
  } catch (const std::length_error&) {}
  fail(CHIASM_OUT_OF_MEMORY, what + ": out of memory: it needs " + std::to_string(size) + " bytes");
}

// O_NONBLOCK: opening a pipe must not wait for its writer.
Bytes read_file(const std::string& path, uint64_t limit) {
  return read_whole(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK), path, limit);
}

std::string sha256(const void* data, size_t size) {
  uint8_t digest[crypto_hash_sha256_BYTES];
  crypto_hash_sha256(digest, static_cast<const uint8_t*>(data), size);
  static const char* const kHex = "0123456789abcdef";
  std::string text;
  text.reserve(2 * sizeof digest);
  for (const uint8_t byte : digest) {
    text += kHex[byte >> 4];
    text += kHex[byte & 15];
  }
  return text;
}

Folder::Folder(const std::string& path)
    : path_(path), descriptor_(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ >= 0) return;
  struct stat info {};
  const int reason = errno;
  if (reason == ENOTDIR && ::stat(path.c_str(), &info) == 0)
    fail(CHIASM_CORRUPT, path + " is not a bundle: a bundle is a folder");
  errno = reason;
  fail_by_system("cannot open the bundle " + path);
}

Folder::~Folder() { ::close(descriptor_); }

int Folder::open_file(const std::string& name) const {
  const int direct = ::openat(descriptor_, name.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW);
  if (direct >= 0 || errno != ELOOP) return direct;
  // A link. O_PATH finds its target without opening it; the target is opened only if it is in this folder.
  const Descriptor target(::openat(descriptor_, name.c_str(), O_PATH | O_CLOEXEC));
  if (target.value() < 0) return -1;
  const std::string inside = place_of(descriptor_) + "/", place = place_of(target.value());
  if (inside.size() == 1 || place.compare(0, inside.size(), inside) != 0) {
    fail(CHIASM_CORRUPT, path_ + "/" + name + ": is a link that leaves the bundle's folder" +
                             (place.empty() ? "" : ", to " + printable(place)) +
                             ": put the file itself there");
  }
  return ::open(("/proc/self/fd/" + std::to_string(target.value())).c_str(),
                O_RDONLY | O_CLOEXEC | O_NONBLOCK);
}

Bytes Folder::read(const std::string& name, uint64_t limit) const {
  return read_whole(open_file(name), path_ + "/" + name, limit);
}

Bytes Folder::read_checked(const std::string& name, uint64_t size, std::string_view expected_sha256) const {
  const std::string path = path_ + "/" + name;
  Bytes bytes = read(name, size);
  if (bytes.size() < size) {
    fail(CHIASM_CORRUPT, path + ": truncated: has " + std::to_string(bytes.size()) +
                             " bytes, the manifest says " + std::to_string(size));
  }
  const std::string actual = sha256(bytes.data(), bytes.size());
  if (actual != expected_sha256) {
    fail(CHIASM_CORRUPT, path + ": changed since the bundle was made: its sha256 is " + actual +
                             ", the manifest says " + std::string(expected_sha256));
  }
  return bytes;
}

void Folder::only(const std::set<std::string>& names) const {
  const int again = ::openat(descriptor_, ".",
                             O_RDONLY | O_DIRECTORY | O_CLOEXEC);  // it has a position of its own
  const std::unique_ptr<DIR, int (*)(DIR*)> listing(again < 0 ? nullptr : ::fdopendir(again), ::closedir);
  if (listing == nullptr) {
    const Descriptor closed(again);
    fail_by_system(path_);
  }
  errno = 0;
  while (const dirent* const entry = ::readdir(listing.get())) {
    const std::string name = entry->d_name;
    if (name != "." && name != ".." && names.count(name) == 0) {
      fail(CHIASM_CORRUPT, path_ + " has '" + printable(name) +
                               "', which its manifest does not name: remove it, or export the bundle again");
    }
    errno = 0;
  }
  if (errno != 0) fail_by_system(path_);
}

}  // namespace chiasm::core
