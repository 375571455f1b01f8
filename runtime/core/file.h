/** Files of a bundle: read whole, then checked, then used; nothing is read twice. */
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "chiasm/chiasm.h"

namespace chiasm::core {

using Bytes = std::vector<unsigned char>;

/** The file's content. Throws Error that names the file: NOT_FOUND where there is none, CORRUPT where it is
 *  no regular file or has more than `limit` bytes, OUT_OF_MEMORY, and IO_ERROR for what else the system
 *  says. */
Bytes read_file(const std::string& path, uint64_t limit);

/** So many zeros. Throws Error (OUT_OF_MEMORY) that says for what, and how many. */
Bytes make_bytes(uint64_t size, const std::string& what);

/** Lower-case hexadecimal SHA-256. */
std::string sha256(const void* data, size_t size);

/** A bundle's folder, opened: its files are found from there, wherever its path leads later. */
class Folder final {
 public:
  /** The path may go through links. Throws Error: NOT_FOUND, IO_ERROR, CORRUPT where it is no folder. */
  explicit Folder(const std::string& path);
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder();

  /** As read_file. Where the file is a link, what it leads to must lie in this folder too (else CORRUPT). */
  Bytes read(const std::string& name, uint64_t limit) const;

  /** The content, proved to be what the manifest says. Throws Error, as above. */
  Bytes read_checked(const std::string& name, uint64_t size, std::string_view expected_sha256) const;

  /** Throws Error (CORRUPT) that names an entry which is not among these. */
  void only(const std::set<std::string>& names) const;

 private:
  int open_file(const std::string& name) const;

  std::string path_;
  int descriptor_;
};

}  // namespace chiasm::core
