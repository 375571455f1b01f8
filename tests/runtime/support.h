/** Shared parts of tests: temporary folders, and small bundles to open or to damage. */
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "chiasm/chiasm.hpp"

namespace chiasm::testing {

/** A folder that is deleted with this object. */
class TemporaryFolder final {
 public:
  TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  const std::string& path() const { return path_; }
  std::string write(const std::string& name, const std::string& content) const;

 private:
  std::string path_;
};

std::string read_text(const std::string& path);
void write_text(const std::string& path, const std::string& text);
std::string sha256_of(const std::string& content);

/** A safetensors file of float32 tensors. */
struct NamedTensor {
  std::string name;
  std::vector<int64_t> shape;
  std::vector<float> values;
};
std::string safetensors(const std::vector<NamedTensor>& tensors);

/** A manifest of a made-up op, `test.scale`, complete and valid:
 *
 *      forward: input T (B, 3, H, W), sigma T (B, 2)  ->  output T (B, 3, H, W), half T (B, (H+1)//2)
 *      vjp:     input T (B, 3, H, W), grad_half T (B, (H+1)//2)  ->  grad_input T (B, 3, H, W)
 *
 *  with artifacts for native (v3 and v4: "scale 2"), torch ("scale 2") and onnx (float32 and float64: "scale
 *  2").
 */
nlohmann::json manifest();

/** Writes its files, with matching sizes and hashes in the manifest. `change` may then alter the manifest;
 *  files that it no longer names are omitted. Returns the path. */
std::string write_bundle(const TemporaryFolder& folder,
                         const std::function<void(nlohmann::json&)>& change = {});

/** An artifact that a fake backend reads as these words (fewer than 128 characters); for `.onnx`, a model
 *  with these words as its doc_string. */
std::string artifact_content(const std::string& file, const std::string& words);

/** Replaces the words of an artifact, and its size and hash in the manifest. */
void set_artifact(const std::string& bundle, const std::string& file, const std::string& words);

/** The message of the error that `body` throws; fails if there is none, or one with another code. */
template <class AnyError = Error, class Body>
std::string refusal(chiasm_code code, const Body& body) {
  try {
    body();
  } catch (const AnyError& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "was accepted";
  return "";
}

}  // namespace chiasm::testing
