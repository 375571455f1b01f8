/** The C++ header alone compiles as strict C++17, included twice and in two files. */
#include "chiasm/chiasm.hpp"

static_assert(!std::is_copy_constructible_v<chiasm::Bundle> &&
              std::is_nothrow_move_constructible_v<chiasm::Bundle>);
static_assert(!std::is_copy_constructible_v<chiasm::Method> &&
              std::is_nothrow_move_constructible_v<chiasm::Method>);
static_assert(!std::is_copy_constructible_v<chiasm::Outputs> &&
              std::is_nothrow_move_constructible_v<chiasm::Outputs>);
static_assert(std::is_copy_constructible_v<chiasm::Tensor>);

bool chiasm_headers_as_cpp17();
bool chiasm_headers_as_cpp17() { return !chiasm::library_version().empty(); }
