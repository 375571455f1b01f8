// Reads the header of a safetensors file and checks each tensor's offsets against its dtype and shape.
#include "core/safetensors.h"

#include "base/dtype.h"
#include "core/json.h"
#include "core/status.h"

namespace chiasm::core {
namespace {

constexpr size_t kPrefix = 8;  // the header's length, little-endian
constexpr uint64_t kMaxHeader = 16u << 20;
constexpr size_t kMaxStoredTensors = 65536;

StoredTensor read_tensor(const JsonNode& node, const unsigned char* data, size_t data_size) {
  node.only({"dtype", "shape", "data_offsets"});
  StoredTensor tensor;
  const JsonNode dtype = node.at("dtype");
  tensor.dtype = dtype_from_safetensors(dtype.string(64));
  if (tensor.dtype < 0) dtype.refuse("unknown dtype '" + dtype.string() + "'");
  int64_t bytes = static_cast<int64_t>(kDTypes[tensor.dtype].size);
  for (const JsonNode& dim : node.at("shape").elements(0, CHIASM_MAX_DIMS)) {
    const int64_t size = dim.integer(0, INT64_MAX);
    if (__builtin_mul_overflow(bytes, size, &bytes)) dim.refuse("the tensor is too large");
    tensor.shape.push_back(size);
  }
  const JsonNode offsets = node.at("data_offsets");
  const auto limits = offsets.elements(2, 2);
  const int64_t end = limits[1].integer(0, static_cast<int64_t>(data_size));
  const int64_t begin = limits[0].integer(0, end);
  if (end - begin != bytes) {
    offsets.refuse("span " + std::to_string(end - begin) + " bytes, but dtype and shape need " +
                   std::to_string(bytes));
  }
  tensor.data = data + begin;
  tensor.size = static_cast<size_t>(bytes);
  return tensor;
}

}  // namespace

std::map<std::string, StoredTensor> read_safetensors(const unsigned char* bytes, size_t size,
                                                     const std::string& origin) {
  if (size < kPrefix) fail(CHIASM_CORRUPT, origin + ": shorter than a safetensors file can be");
  uint64_t header_size = 0;
  for (size_t i = 0; i < kPrefix; ++i) header_size |= static_cast<uint64_t>(bytes[i]) << (8 * i);
  if (header_size > size - kPrefix || header_size > kMaxHeader) {
    fail(CHIASM_CORRUPT, origin + ": says that its header has " + std::to_string(header_size) +
                             " bytes, but the file has " + std::to_string(size));
  }
  const std::string_view header(reinterpret_cast<const char*>(bytes) + kPrefix, header_size);
  const JsonDocument document = parse_json(header, origin);
  const unsigned char* const data = bytes + kPrefix + header_size;
  std::map<std::string, StoredTensor> tensors;
  for (const auto& member : JsonNode(document.value, origin).members(0, kMaxStoredTensors)) {
    if (member.key == "__metadata__") continue;
    tensors.emplace(member.key, read_tensor(member.node, data, size - kPrefix - header_size));
  }
  return tensors;
}

}  // namespace chiasm::core
