/** A bundle's manifest, read strictly. The fields below have been checked; nothing else of the file is
 *  used. */
#pragma once

#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/dtype.h"
#include "base/error.h"
#include "chiasm/chiasm.h"
#include "core/expression.h"

namespace chiasm::core {

using namespace base;

/** The newest schema_version that this library reads. */
inline constexpr int64_t kSchemaVersion = 3;
/** The most inputs or outputs of a method, so that a run needs no memory of its own. */
inline constexpr size_t kMaxTensors = 64;
/** The longest manifest, in bytes. */
inline constexpr uint64_t kMaxManifestSize = 16u << 20;
/** The dtype of a tensor whose dtype is the type variable T. */
inline constexpr int32_t kGeneric = -1;

enum class DevicePlacement { any, cpu, cuda };
/** Instruction sets, in ascending order within each family of CPUs. */
enum class Isa { none, x86_64_v2, x86_64_v3, x86_64_v4, armv8_2_a };
/** The names of all but `none`. */
inline constexpr const char* kIsaNames[] = {"x86-64-v2", "x86-64-v3", "x86-64-v4", "armv8.2-a"};
/** The name of an instruction set that is not `none`. */
constexpr const char* isa_name(Isa isa) { return kIsaNames[static_cast<int>(isa) - 1]; }

struct TensorSpec {
  std::string name, description, layout, color;
  int32_t dtype = kGeneric; /**< a chiasm_dtype, or kGeneric */
  std::vector<Expression> shape;
  double value_min = 0, value_max = 0;
};

/** A file of the bundle, inside its folder. */
struct BundleFile {
  std::string file, sha256;
  uint64_t size = 0;
};

/** The format of an ONNX model whose graph is one function that stands for native code of the bundle.
 *  Manifests call it "onnx" and name the function. */
inline constexpr const char* kFusedOnnx = "fused_onnx";

/** A version of the C library: 2.31 is {2, 31}. */
struct GlibcVersion {
  int major = 0, minor = 0;
};

struct Artifact : BundleFile {
  std::string backend; /**< the backend that loads it; perhaps not installed here */
  std::string format;
  std::vector<int32_t> dtypes; /**< values of T that it supports */
  DevicePlacement device = DevicePlacement::any;
  Isa isa = Isa::none;
  int64_t sm = 0;                             /**< compute capability, 90 for 9.0; 0 if not stated */
  GlibcVersion glibc;                         /**< the oldest that it runs with; 0.0 if not stated */
  std::vector<std::string> needs;             /**< engines that it needs besides its backend's */
  std::string why;                            /**< which operator needs them; "" if not stated */
  std::map<std::string, std::string> options; /**< its options for the backend */

  /** "" if there is no such key. */
  std::string option(const std::string& key) const {
    const auto found = options.find(key);
    return found == options.end() ? "" : found->second;
  }
};

struct Tolerance {
  double atol = 0, rtol = 0;
};

struct MethodSpec {
  std::string name;
  std::vector<TensorSpec> inputs, outputs;
  /** of the outputs, by chiasm_dtype; none means exact */
  std::array<std::optional<Tolerance>, kDTypeCount> tolerances;
  std::vector<Artifact> artifacts;
  bool generic = false; /**< whether some tensor is of dtype T */
  /** Bit i is set if input (output) i begins with the symbol that counts independent samples; 0 if there is
   *  no such symbol. */
  uint64_t batched_inputs = 0, batched_outputs = 0;
};

struct Symbol {
  std::string name;
  int64_t min = 1, max = 1;
};

struct GoldenCase {
  std::string prefix;
  size_t method = 0;
  int32_t dtype = kGeneric; /**< what T stands for in this case */
};

struct Manifest {
  std::string name, version, summary;
  std::vector<Symbol> symbols;
  std::vector<int32_t> dtypes; /**< what T may stand for */
  std::vector<MethodSpec> methods;
  BundleFile golden;
  std::vector<GoldenCase> golden_cases;
  /** files about the bundle: its list of parts and its provenance */
  std::vector<BundleFile> documents;
  std::set<std::string> files; /**< the names of all these */
};

/** Read a manifest. `origin` is the file's name, for messages. Throws Error for anything that is not a valid
 *  manifest: VERSION_MISMATCH for a newer schema, CORRUPT for everything else. */
Manifest parse_manifest(std::string_view text, const std::string& origin);

}  // namespace chiasm::core
