#include "backends/native/archive.h"

#include <cstdint>
#include <string>

#include "base/error.h"

// The format is PKWARE's specification, APPNOTE.TXT, without the features that Python's zipfile does not use
// for stored files of less than 4 GiB: compression, encryption, several disks, ZIP64.
namespace chiasm::native {
namespace {

constexpr uint32_t kEndSignature = 0x06054b50, kEntrySignature = 0x02014b50, kLocalSignature = 0x04034b50;
constexpr std::size_t kEndSize = 22, kEntrySize = 46, kLocalSize = 30;
constexpr std::size_t kLongestComment = 65535;

[[noreturn]] void corrupt(const std::string& what) { base::fail(CHIASM_CORRUPT, what); }

/** Reads numbers and parts of the archive; reading outside of it is an error. */
class Reader final {
 public:
  Reader(const void* data, std::size_t size) : data_(static_cast<const unsigned char*>(data)), size_(size) {}

  std::size_t size() const { return size_; }
  Bytes part(std::size_t offset, std::size_t size) const {
    if (offset > size_ || size > size_ - offset) corrupt("the archive ends before its directory says");
    return {data_ + offset, size};
  }
  uint32_t number(std::size_t offset, std::size_t bytes) const {
    const Bytes at = part(offset, bytes);
    uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value |= uint32_t{at.data[i]} << (8 * i);
    return value;
  }
  uint32_t u16(std::size_t offset) const { return number(offset, 2); }
  uint32_t u32(std::size_t offset) const { return number(offset, 4); }

 private:
  const unsigned char* data_;
  std::size_t size_;
};

/** Where the record at the end of the archive begins. */
std::size_t find_end(const Reader& archive) {
  if (archive.size() < kEndSize) corrupt("not a zip archive");
  const std::size_t last = archive.size() - kEndSize;
  for (std::size_t back = 0; back <= kLongestComment && back <= last; ++back) {
    const std::size_t at = last - back;
    if (archive.u32(at) == kEndSignature && archive.u16(at + 20) == back) return at;
  }
  corrupt("not a zip archive");
}

struct Entry {
  std::string name;
  std::size_t local, size;  // where its local header is, and its bytes
  std::size_t next;         // where the next entry of the directory is
};

Entry read_entry(const Reader& archive, std::size_t at) {
  if (archive.u32(at) != kEntrySignature) corrupt("damaged directory of the archive");
  const std::size_t name_size = archive.u16(at + 28);
  const Bytes name = archive.part(at + kEntrySize, name_size);
  Entry entry{std::string(reinterpret_cast<const char*>(name.data), name.size), archive.u32(at + 42),
              archive.u32(at + 24),
              at + kEntrySize + name_size + archive.u16(at + 30) + archive.u16(at + 32)};
  const bool stored = archive.u16(at + 10) == 0 && archive.u32(at + 20) == entry.size;
  const bool encrypted = (archive.u16(at + 8) & 1u) != 0;
  if (!stored || encrypted)
    corrupt("'" + entry.name + "' in the archive is compressed or encrypted; expected stored files");
  return entry;
}

Bytes content(const Reader& archive, const Entry& entry) {
  if (archive.u32(entry.local) != kLocalSignature)
    corrupt("damaged header of '" + entry.name + "' in the archive");
  return archive.part(
      entry.local + kLocalSize + archive.u16(entry.local + 26) + archive.u16(entry.local + 28), entry.size);
}

bool is_library(const std::string& name) {
  return name.size() >= 3 && name.compare(name.size() - 3, 3, ".so") == 0;
}

}  // namespace

Bytes find_library(const void* data, std::size_t size) {
  const Reader archive(data, size);
  const std::size_t end = find_end(archive);
  const uint32_t count = archive.u16(end + 10);
  std::size_t at = archive.u32(end + 16);
  std::string name;
  Bytes library{nullptr, 0};
  for (uint32_t i = 0; i < count; ++i) {
    const Entry entry = read_entry(archive, at);
    at = entry.next;
    if (!is_library(entry.name)) continue;
    if (library.data != nullptr)
      corrupt("two shared libraries in the archive, " + name + " and " + entry.name + "; expected one");
    name = entry.name;
    library = content(archive, entry);
  }
  if (library.data == nullptr) corrupt("no shared library (*.so) in the archive");
  return library;
}

}  // namespace chiasm::native
