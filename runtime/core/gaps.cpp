// Finds out whether a tensor's elements have gaps between them, and copies such tensors to dense memory and
// back in as few loops as possible.
#include "core/gaps.h"

#include <cstring>
#include <new>
#include <string>

#include "base/dtype.h"
#include "core/status.h"

namespace chiasm::core {
namespace {

/** The fewest loops over a tensor's elements: dimensions of size 1 are dropped, and dimensions without a gap
 *  between them are merged. */
struct Loops {
  int64_t sizes[CHIASM_MAX_DIMS], strides[CHIASM_MAX_DIMS];
  int32_t count = 0;

  explicit Loops(const chiasm_tensor& tensor) {
    for (int32_t i = 0; i < tensor.ndim; ++i) {
      if (tensor.shape[i] == 1) continue;
      const int64_t size = tensor.shape[i], stride = tensor.strides[i];
      if (count > 0 && strides[count - 1] == size * stride) {
        sizes[count - 1] *= size;
        strides[count - 1] = stride;
      } else {
        sizes[count] = size;
        strides[count++] = stride;
      }
    }
  }
};

/** Calls each(apart, dense), offsets in elements, for the first element of each of the innermost rows. */
template <class Each>
void for_rows(const Loops& loops, const Each& each) {
  int64_t index[CHIASM_MAX_DIMS] = {}, apart = 0, dense = 0;
  const int32_t inner = loops.count - 1;
  for (;;) {
    each(apart, dense);
    dense += loops.sizes[inner];
    int32_t i = inner - 1;
    for (; i >= 0; --i) {
      apart += loops.strides[i];
      if (++index[i] < loops.sizes[i]) break;
      apart -= loops.strides[i] * loops.sizes[i];
      index[i] = 0;
    }
    if (i < 0) return;
  }
}

/** Copies element by element. T has an element's size, so that each copy is one instruction. */
template <class T>
void copy_elements(const Loops& loops, char* apart, char* dense, bool gather) {
  const int64_t count = loops.sizes[loops.count - 1],
                step = loops.strides[loops.count - 1] * static_cast<int64_t>(sizeof(T));
  for_rows(loops, [&](int64_t from, int64_t to) {
    char* far = apart + from * static_cast<int64_t>(sizeof(T));
    char* near = dense + to * static_cast<int64_t>(sizeof(T));
    for (int64_t i = 0; i < count; ++i, far += step, near += sizeof(T))
      std::memcpy(gather ? near : far, gather ? far : near, sizeof(T));
  });
}

/** Copies `tensor`, which has gaps, to dense memory (`gather`), or dense memory to `tensor`. */
void copy(const chiasm_tensor& tensor, void* dense, bool gather) {
  const Loops loops(tensor);
  const size_t size = base::kDTypes[tensor.dtype].size;
  auto* const apart = static_cast<char*>(tensor.data);
  auto* const near = static_cast<char*>(dense);
  if (loops.strides[loops.count - 1] == 1) {
    const size_t bytes = static_cast<size_t>(loops.sizes[loops.count - 1]) * size;
    for_rows(loops, [&](int64_t from, int64_t to) {
      char* const a = apart + from * static_cast<int64_t>(size);
      char* const b = near + to * static_cast<int64_t>(size);
      std::memcpy(gather ? b : a, gather ? a : b, bytes);
    });
    return;
  }
  switch (size) {
    case 1: return copy_elements<uint8_t>(loops, apart, near, gather);
    case 2: return copy_elements<uint16_t>(loops, apart, near, gather);
    case 4: return copy_elements<uint32_t>(loops, apart, near, gather);
    default: return copy_elements<uint64_t>(loops, apart, near, gather);
  }
}

}  // namespace

Order order_of(const chiasm_tensor& tensor) {
  int64_t bytes = static_cast<int64_t>(base::kDTypes[tensor.dtype].size);  // to the end of the last element
  int64_t needed = 1;  // the smallest next outer stride with which no two elements share memory
  bool gaps = false;
  for (int32_t i = tensor.ndim - 1; i >= 0; --i) {
    const int64_t size = tensor.shape[i], stride = tensor.strides[i];
    if (size == 1) continue;
    if (stride < needed) return Order::no_order;
    gaps = gaps || stride != needed;
    int64_t elements = 0, reach = 0;  // from the first to the last along this dimension
    if (__builtin_mul_overflow(stride, size - 1, &elements) ||
        __builtin_add_overflow(needed, elements, &needed) ||
        __builtin_mul_overflow(elements, base::kDTypes[tensor.dtype].size, &reach) ||
        __builtin_add_overflow(bytes, reach, &bytes))
      return Order::no_order;
  }
  return gaps ? Order::gaps : Order::dense;
}

size_t bytes_spanned(const chiasm_tensor& tensor) {
  int64_t elements = 1;
  for (int32_t i = 0; i < tensor.ndim; ++i) {
    if (tensor.shape[i] == 0) return 0;
    if (tensor.strides != nullptr && tensor.shape[i] > 1)
      elements += (tensor.shape[i] - 1) * tensor.strides[i];
  }
  if (tensor.strides == nullptr) return base::byte_count(tensor);
  return static_cast<size_t>(elements) * base::kDTypes[tensor.dtype].size;
}

std::vector<Rows> rows_of(const chiasm_tensor& tensor) {
  const auto begin = reinterpret_cast<uintptr_t>(tensor.data);
  const size_t bytes = bytes_spanned(tensor);
  if (bytes == 0) return {};
  if (tensor.strides == nullptr || order_of(tensor) == Order::dense) return {{begin, bytes, bytes, bytes}};
  Loops loops(tensor);
  const size_t size = base::kDTypes[tensor.dtype].size;
  size_t row = size;
  if (loops.strides[loops.count - 1] == 1) row *= static_cast<size_t>(loops.sizes[--loops.count]);
  // there is a loop around the row, or it would have no gap; those around that one lead from part to part
  const size_t pitch = static_cast<size_t>(loops.strides[loops.count - 1]) * size;
  const size_t of_part = static_cast<size_t>(loops.sizes[loops.count - 1] - 1) * pitch + row;
  std::vector<Rows> parts;
  for_rows(loops, [&](int64_t apart, int64_t) {
    parts.push_back({begin + static_cast<size_t>(apart) * size, of_part, row, pitch});
  });
  return parts;
}

DenseCopies::DenseCopies(Call& call, const chiasm_tensor* inputs, const chiasm_tensor* outputs) {
  for (uint64_t left = call.gaps_in_inputs; left != 0; left &= left - 1) {
    const auto i = static_cast<size_t>(__builtin_ctzll(left));
    call.inputs[i].data = memory_for(call.inputs[i], "input", i);
    copy(tensor_at(inputs, i), call.inputs[i].data, true);
  }
  for (uint64_t left = call.gaps_in_outputs; left != 0; left &= left - 1) {
    const auto i = static_cast<size_t>(__builtin_ctzll(left));
    call.outputs[i].data = memory_for(call.outputs[i], "output", i);
    spreads_.push_back({call.outputs[i].data, &tensor_at(outputs, i)});
  }
}

void DenseCopies::spread() const {
  for (const Spread& one : spreads_) copy(*one.target, one.dense, false);
}

void* DenseCopies::memory_for(const chiasm_tensor& dense, const char* kind, size_t index) {
  const size_t bytes = base::byte_count(dense);
  try {
    memory_.emplace_back(bytes);
  } catch (const std::bad_alloc&) {
    fail(CHIASM_OUT_OF_MEMORY,
         std::string(kind) + " " + std::to_string(index) +
             ": out of memory: it has gaps between its rows, and a dense copy of it needs " +
             std::to_string(bytes) + " bytes");
  }
  return memory_.back().data();
}

}  // namespace chiasm::core
