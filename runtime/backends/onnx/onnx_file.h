/** A look into the bytes of an ONNX model, before an engine reads them. */
#pragma once

#include <cstddef>
#include <string>

namespace chiasm::onnx {

/** Checks that the model contains all its data, none of it in another file, and at most one function. Throws
 *  Error (CORRUPT) that names `origin`, also for bytes that are no ONNX model. */
void check_onnx(const unsigned char* data, size_t size, const std::string& origin);

}  // namespace chiasm::onnx
