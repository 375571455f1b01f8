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

/** The file's content. Throws Error that names the file: NOT_FOUND if there is none, CORRUPT if it is no
 *  regular file or has more than `limit` bytes, OUT_OF_MEMORY, and IO_ERROR for any other error of the
 *  system. */
Bytes read_file(const std::string& path, uint64_t limit);

/** `size` zeros. Throws Error (OUT_OF_MEMORY) that names `what` and the size. */
Bytes make_bytes(uint64_t size, const std::string& what);

/** Lower-case hexadecimal SHA-256. */
std::string sha256(const void* data, size_t size);

/** A bundle's open folder. Its files are opened relative to it, even if its path leads elsewhere later. */
class Folder final {
 public:
  /** The path may go through links. Throws Error: NOT_FOUND, IO_ERROR, CORRUPT if it is no folder. */
  explicit Folder(const std::string& path);
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder();

  /** As read_file. If the file is a link, its target must be in this folder too (else CORRUPT). */
  Bytes read(const std::string& name, uint64_t limit) const;

  /** The content, after its size and hash have been compared with these. Throws Error, as above. */
  Bytes read_checked(const std::string& name, uint64_t size, std::string_view expected_sha256) const;

  /** Throws Error (CORRUPT) if the folder has an entry that is not among `names`. */
  void only(const std::set<std::string>& names) const;

 private:
  int open_file(const std::string& name) const;

  std::string path_;
  int descriptor_;
};

}  // namespace chiasm::core
