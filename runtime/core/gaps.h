/** Tensors with gaps: elements in row-major order with unused memory between them, as in a region of a larger
 *  image. Engines read and write dense memory, so such inputs are copied before a run and such outputs after
 *  it. */
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/pool.h"
#include "core/signature.h"

namespace chiasm::core {

/** How the elements of a tensor lie in memory. */
enum class Order {
  dense,
  gaps,     /**< row-major, with gaps: no two elements share memory */
  no_order, /**< transposed, repeated, backwards, or further apart than memory is large */
};

/** `tensor` must have at least one element. */
Order order_of(const chiasm_tensor& tensor);

/** The bytes from a tensor's first element to the end of its last, including gaps. */
size_t bytes_spanned(const chiasm_tensor& tensor);

/** A part of a tensor's memory: rows without gaps, which begin one pitch apart. One row is as long as its
 *  pitch. */
struct Rows {
  uintptr_t begin;
  size_t bytes; /**< to the end of the last row */
  size_t row, pitch;
};

/** The parts of which a tensor consists: one if it is dense or a region of a frame, one for each plane of a
 *  region of planes, one for each row if there are gaps between the pixels of a region. None of them begins
 *  within another. `tensor` is not in Order::no_order. */
std::vector<Rows> rows_of(const chiasm_tensor& tensor);

/** Dense copies of a call's tensors with gaps, which the engine gets instead. Keep them until the run
 *  ends. */
class DenseCopies final {
 public:
  /** Copies the inputs that have gaps, allocates memory for the outputs that have gaps, and enters both in
   *  `call`. `inputs` and `outputs` are the caller's checked tensors; `outputs` may be NULL. Throws Error
   *  (OUT_OF_MEMORY). */
  DenseCopies(Call& call, const chiasm_tensor* inputs, const chiasm_tensor* outputs);

  /** After the run: copies the results of outputs with gaps to the caller's memory. */
  void spread() const;

 private:
  void* memory_for(const chiasm_tensor& dense, const char* kind, size_t index);

  std::vector<base::PooledMemory> memory_;
  struct Spread {
    void* dense;
    const chiasm_tensor* target;
  };
  std::vector<Spread> spreads_;
};

}  // namespace chiasm::core
