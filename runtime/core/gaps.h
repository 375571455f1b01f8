/** Tensors with gaps: elements in row-major order that do not follow each other without a break, as those of a
 *  region of a larger image. Engines see dense memory: what has gaps is copied before and after a run. */
#pragma once

#include <vector>

#include "base/pool.h"
#include "core/signature.h"

namespace chiasm::core {

/** How far the elements of a tensor are apart. */
enum class Order {
  dense,
  gaps,     /**< row-major, with gaps: no two elements share memory */
  no_order, /**< transposed, repeated, backwards, or further apart than memory is large */
};

/** `tensor` has an element at least. */
Order order_of(const chiasm_tensor& tensor);

/** The bytes from a tensor's first element to behind its last, with what is between them. */
size_t bytes_spanned(const chiasm_tensor& tensor);

/** The dense memory that engines see in place of a call's tensors with gaps. It lives as long as the run. */
class DenseCopies final {
 public:
  /** Copies the inputs that have gaps, and gives the outputs that have them memory; `call` has it then.
   *  `inputs` and `outputs` are the caller's, which were checked; `outputs` is NULL where it has none. Throws
   *  Error (OUT_OF_MEMORY). */
  DenseCopies(Call& call, const chiasm_tensor* inputs, const chiasm_tensor* outputs);

  /** After the run: what outputs with gaps got, to where the caller wants it. */
  void spread() const;

 private:
  void* memory_for(const chiasm_tensor& dense, const char* kind, size_t index);

  std::vector<base::PooledMemory> memory_;
  struct Spread {
    const void* dense;
    const chiasm_tensor* target;
  };
  std::vector<Spread> spreads_;
};

}  // namespace chiasm::core
