#include "backends/onnx/onnx_file.h"

#include <cstdint>
#include <cstring>

#include "base/error.h"

namespace chiasm::onnx {
namespace {

using base::fail;

// The messages of onnx.proto that lead to a tensor, and the numbers of their fields that do.
enum class Message { model, training, function, graph, node, attribute, sparse_tensor, tensor };

struct Step {
  Message in;
  uint32_t field;
  Message to;
};

constexpr Step kSteps[] = {
    {Message::model, 7, Message::graph},
    {Message::model, 20, Message::training},
    {Message::model, 25, Message::function},
    {Message::training, 1, Message::graph},
    {Message::training, 2, Message::graph},
    {Message::function, 7, Message::node},
    {Message::function, 11, Message::attribute},
    {Message::graph, 1, Message::node},
    {Message::graph, 5, Message::tensor},
    {Message::graph, 15, Message::sparse_tensor},
    {Message::node, 5, Message::attribute},
    {Message::attribute, 5, Message::tensor},
    {Message::attribute, 6, Message::graph},
    {Message::attribute, 10, Message::tensor},
    {Message::attribute, 11, Message::graph},
    {Message::attribute, 22, Message::sparse_tensor},
    {Message::attribute, 23, Message::sparse_tensor},
    {Message::sparse_tensor, 1, Message::tensor},
    {Message::sparse_tensor, 2, Message::tensor},
};
constexpr uint32_t kTensorExternalData = 13, kTensorDataLocation = 14;

/** protobuf's own limit: no parser reads a deeper message. */
constexpr int kMaxDepth = 100;

/** Walks over protobuf's wire format. It must see every tensor that an engine's parser would see, so it
 *  rejects bytes that a parser would read differently or reject. */
class Walk final {
 public:
  Walk(const unsigned char* data, const std::string& origin) : at_(data), origin_(origin) {}

  void message(Message kind, const unsigned char* end, int depth) {
    if (depth > kMaxDepth) refuse("nested deeper than " + std::to_string(kMaxDepth) + " levels");
    while (at_ < end) {
      const uint64_t tag = varint(end);
      if (tag > UINT32_MAX || tag < 8) refuse("its bytes are damaged");
      const auto field = static_cast<uint32_t>(tag >> 3);
      switch (tag & 7) {
        case kVarint: {
          const uint64_t value = varint(end);
          if (kind == Message::tensor && field == kTensorDataLocation && value != 0) refuse_external();
          break;
        }
        case kFixed64: skip(8, end); break;
        case kFixed32: skip(4, end); break;
        case kBytes: {
          const uint64_t size = varint(end);
          if (size > static_cast<size_t>(end - at_)) refuse("its bytes are damaged");
          if (kind == Message::tensor && field == kTensorExternalData) refuse_external();
          inside(kind, field, at_ + size, depth);
          break;
        }
        default: refuse("its bytes are damaged");  // also groups, which ONNX does not use
      }
    }
  }

 private:
  static constexpr uint64_t kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5;

  [[noreturn]] void refuse(const std::string& what) const {
    fail(CHIASM_CORRUPT, origin_ + ": not an ONNX model: " + what);
  }

  [[noreturn]] void refuse_external() const {
    fail(
        CHIASM_CORRUPT,
        origin_ +
            ": keeps data of a tensor in another file, which no hash covers: export it with its data inside");
  }

  [[noreturn]] void refuse_functions() const {
    fail(CHIASM_CORRUPT,
         origin_ +
             ": has more than one function, and chiasm's models have at most one: engines inline functions"
             " in each other without a limit, until time or the stack runs out");
  }

  void inside(Message kind, uint32_t field, const unsigned char* end, int depth) {
    for (const Step& step : kSteps) {
      if (step.in != kind || step.field != field) continue;
      if (step.to == Message::function && has_function_) refuse_functions();
      has_function_ = has_function_ || step.to == Message::function;
      message(step.to, end, depth + 1);
    }
    at_ = end;
  }

  uint64_t varint(const unsigned char* end) {
    uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      if (at_ == end) refuse("its bytes are damaged");
      const unsigned char byte = *at_++;
      value |= static_cast<uint64_t>(byte & 127) << shift;
      if (byte < 128) return value;
    }
    refuse("its bytes are damaged");
  }

  void skip(size_t size, const unsigned char* end) {
    if (size > static_cast<size_t>(end - at_)) refuse("its bytes are damaged");
    at_ += size;
  }

  const unsigned char* at_;
  const std::string& origin_;
  bool has_function_ = false;
};

}  // namespace

void check_onnx(const unsigned char* data, size_t size, const std::string& origin) {
  // ONNX Runtime also reads its own format, which it recognises by this mark.
  if (size >= 8 && std::memcmp(data + 4, "ORTM", 4) == 0)
    fail(CHIASM_CORRUPT, origin + ": is in ONNX Runtime's own format, not ONNX");
  Walk(data, origin).message(Message::model, data + size, 0);
}

}  // namespace chiasm::onnx
