/** A reader of the safetensors format: a length, a JSON header, then the tensors' bytes. */
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/file.h"

namespace chiasm::core {

struct StoredTensor {
  int32_t dtype = 0; /**< a chiasm_dtype */
  std::vector<int64_t> shape;
  const unsigned char* data = nullptr; /**< may be unaligned */
  size_t size = 0;
};

/** Tensors by name, as views of `bytes`, which must outlive them. Every offset is checked. Throws Error
 *  (CORRUPT) that names `origin`. */
std::map<std::string, StoredTensor> read_safetensors(const unsigned char* bytes, size_t size,
                                                     const std::string& origin);

}  // namespace chiasm::core
