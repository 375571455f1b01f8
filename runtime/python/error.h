/** The C++ interface for this module. */
#pragma once

#include <chiasm/chiasm.hpp>

namespace chiasm::python {

using chiasm::Error;  // becomes chiasm.runtime.ChiasmError
using chiasm::detail::api;
using chiasm::detail::check;

}  // namespace chiasm::python
