/** Strict, typed access to JSON: every error names the file and the place in it. */
#pragma once

#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "chiasm/chiasm.h"

namespace chiasm::core {

/** A parsed document. nlohmann's destructor collects the members of an object or array in a vector, and ends
 *  the process if there is no memory for it; this destructor empties them first. */
struct JsonDocument final {
  JsonDocument() = default;
  JsonDocument(JsonDocument&&) = default;
  JsonDocument& operator=(JsonDocument&&) = delete;
  ~JsonDocument();

  nlohmann::json value;
};

/** Parse text that may hold anything. Throws Error (CHIASM_CORRUPT) for text that is not JSON, is nested
 *  deeper than 32 levels, or has the same key twice in one object. */
JsonDocument parse_json(std::string_view text, const std::string& origin);

/** A value of a document together with its place. The document must outlive it. */
class JsonNode final {
 public:
  JsonNode(const nlohmann::json& value, const std::string& origin) : JsonNode(value, origin, "") {}

  /** Throws Error: "ORIGIN: PATH: what". */
  [[noreturn]] void refuse(const std::string& what, chiasm_code code = CHIASM_CORRUPT) const;

  /** Throws Error unless this is an object that has no other keys than these. */
  void only(std::initializer_list<std::string_view> keys) const;
  bool has(const char* key) const;
  JsonNode at(const char* key) const;

  bool is_null() const { return value_->is_null(); }
  bool is_integer() const { return value_->is_number_integer(); }
  /** At most `max_size` bytes. */
  const std::string& string(size_t max_size = 65536) const;
  int64_t integer(int64_t min, int64_t max) const;
  /** Finite. */
  double number() const;
  bool boolean() const;
  void expect_object() const;

  std::vector<JsonNode> elements(size_t min_count, size_t max_count) const;
  struct Member;
  std::vector<Member> members(size_t min_count, size_t max_count) const;

 private:
  JsonNode(const nlohmann::json& value, const std::string& origin, std::string path)
      : value_(&value), origin_(&origin), path_(std::move(path)) {}
  [[noreturn]] void expected(const std::string& what) const;
  JsonNode child(const nlohmann::json& value, const std::string& key) const;

  const nlohmann::json* value_;
  const std::string* origin_;
  std::string path_;
};

struct JsonNode::Member {
  std::string key;
  JsonNode node;
};

}  // namespace chiasm::core
