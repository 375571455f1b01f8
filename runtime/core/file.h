/** Files of a bundle: read whole, then checked, then used; nothing is read twice. */
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace chiasm::core {

using Bytes = std::vector<unsigned char>;

/** The file's content. Throws Error: NOT_FOUND where there is none, CORRUPT where it is no regular file or has more than
 *  `limit` bytes; each names the file. */
Bytes read_file(const std::string& path, uint64_t limit);

/** Lower-case hexadecimal SHA-256. */
std::string sha256(const void* data, size_t size);

/** The content of a bundle's file, proved to be what the manifest says. Throws Error (NOT_FOUND, CORRUPT). */
Bytes read_checked(const std::string& path, uint64_t size, std::string_view expected_sha256);

}  // namespace chiasm::core
