#include "backends/native/archive.h"

#include <minizip/unzip.h>

#include <memory>
#include <string>
#include <vector>

namespace chiasm::native {
namespace {

using plugin::Error;
using plugin::MemoryFile;

constexpr std::size_t kLargestLibrary = std::size_t{1} << 30;  // what a damaged or hostile header may ask for

[[noreturn]] void corrupt(const std::string& what) { throw Error(CHIASM_CORRUPT, what); }

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

struct CloseArchive {
  void operator()(unzFile archive) const { unzClose(archive); }
};

std::string current_name(unzFile archive, unz_file_info64* info) {
  char name[4096];
  if (unzGetCurrentFileInfo64(archive, info, name, sizeof(name), nullptr, 0, nullptr, 0) != UNZ_OK)
    corrupt("damaged directory of the archive");
  name[sizeof(name) - 1] = '\0';
  return name;
}

MemoryFile extract_current(unzFile archive, std::size_t size) {
  MemoryFile library("chiasm-native");
  if (unzOpenCurrentFile(archive) != UNZ_OK) corrupt("cannot read the shared library in the archive");
  std::vector<char> buffer(std::size_t{1} << 18);
  std::size_t total = 0;
  for (;;) {
    const int n = unzReadCurrentFile(archive, buffer.data(), static_cast<unsigned>(buffer.size()));
    if (n < 0) corrupt("cannot unpack the shared library in the archive");
    if (n == 0) break;
    total += static_cast<std::size_t>(n);
    if (total > size) corrupt("the shared library in the archive is longer than its header says");
    library.write(buffer.data(), static_cast<std::size_t>(n));
  }
  if (unzCloseCurrentFile(archive) != UNZ_OK || total != size) corrupt("the shared library in the archive is damaged");
  library.seal();
  return library;
}

}  // namespace

MemoryFile extract_library(const void* data, std::size_t size) {
  MemoryFile bytes("chiasm-artifact");  // minizip reads files
  bytes.write(data, size);
  bytes.seal();
  const std::string path = bytes.path();
  errno = 0;
  std::unique_ptr<void, CloseArchive> archive(unzOpen64(path.c_str()));
  if (archive == nullptr && (errno == EMFILE || errno == ENFILE || errno == ENOMEM)) throw Error(CHIASM_IO_ERROR, path + ": " + std::strerror(errno));
  if (archive == nullptr) corrupt("not a zip archive");

  std::string found;
  unz64_file_pos position{};
  std::size_t found_size = 0;
  for (int state = unzGoToFirstFile(archive.get()); state != UNZ_END_OF_LIST_OF_FILE; state = unzGoToNextFile(archive.get())) {
    if (state != UNZ_OK) corrupt("damaged directory of the archive");
    unz_file_info64 info{};
    const std::string name = current_name(archive.get(), &info);
    if (!ends_with(name, ".so")) continue;
    if (!found.empty()) corrupt("two shared libraries in the archive, " + found + " and " + name + "; expected one");
    if (info.uncompressed_size > kLargestLibrary) corrupt(name + " says that it is larger than 1 GiB");
    found = name;
    found_size = static_cast<std::size_t>(info.uncompressed_size);
    unzGetFilePos64(archive.get(), &position);
  }
  if (found.empty()) corrupt("no shared library (*.so) in the archive");
  if (unzGoToFilePos64(archive.get(), &position) != UNZ_OK) corrupt("damaged directory of the archive");
  return extract_current(archive.get(), found_size);
}

}  // namespace chiasm::native
