#include "core/json.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/status.h"

namespace chiasm::core {
namespace {

constexpr int kMaxDepth = 32;

using Json = nlohmann::json;

/** Rejects deep nesting and repeated keys, which the parser would accept. */
class Guard final {
 public:
  explicit Guard(const std::string& origin) : origin_(origin) {}

  bool operator()(int depth, Json::parse_event_t event, Json& parsed) {
    if (depth > kMaxDepth)
      fail(CHIASM_CORRUPT, origin_ + ": nested deeper than " + std::to_string(kMaxDepth) + " levels");
    if (event == Json::parse_event_t::object_start) {
      keys_.emplace_back();
    } else if (event == Json::parse_event_t::object_end) {
      keys_.pop_back();
    } else if (event == Json::parse_event_t::key) {
      const auto& key = parsed.get_ref<const std::string&>();
      if (!keys_.back().insert(key).second)
        fail(CHIASM_CORRUPT, origin_ + ": the key '" + key + "' occurs twice");
    }
    return true;
  }

 private:
  const std::string& origin_;
  std::vector<std::set<std::string>> keys_;
};

}  // namespace

Json parse_json(std::string_view text, const std::string& origin) {
  Guard guard(origin);
  const auto callback = [&guard](int depth, Json::parse_event_t event, Json& parsed) {
    return guard(depth, event, parsed);
  };
  try {
    return Json::parse(text.begin(), text.end(), callback);
  } catch (const Json::exception& error) {
    fail(CHIASM_CORRUPT, origin + ": not JSON: " + error.what());
  }
}

void JsonNode::refuse(const std::string& what, chiasm_code code) const {
  fail(code, *origin_ + ": " + (path_.empty() ? "" : path_ + ": ") + what);
}

void JsonNode::expected(const std::string& what) const {
  refuse("expected " + what + ", got " + std::string(value_->type_name()));
}

JsonNode JsonNode::child(const Json& value, const std::string& key) const {
  return JsonNode(value, *origin_, path_.empty() ? key : path_ + "." + key);
}

void JsonNode::expect_object() const {
  if (!value_->is_object()) expected("an object");
}

void JsonNode::only(std::initializer_list<std::string_view> keys) const {
  expect_object();
  for (const auto& item : value_->items()) {
    if (std::find(keys.begin(), keys.end(), item.key()) == keys.end())
      refuse("unknown field '" + item.key() + "'");
  }
}

bool JsonNode::has(const char* key) const { return value_->is_object() && value_->contains(key); }

JsonNode JsonNode::at(const char* key) const {
  expect_object();
  const auto found = value_->find(key);
  if (found == value_->end()) refuse("the field '" + std::string(key) + "' is missing");
  return child(*found, key);
}

const std::string& JsonNode::string(size_t max_size) const {
  if (!value_->is_string()) expected("a string");
  const auto& text = value_->get_ref<const std::string&>();
  if (text.size() > max_size) refuse("longer than " + std::to_string(max_size) + " bytes");
  return text;
}

int64_t JsonNode::integer(int64_t min, int64_t max) const {
  if (!value_->is_number_integer()) expected("an integer");
  const bool too_big =
      value_->is_number_unsigned() && value_->get<uint64_t>() > static_cast<uint64_t>(INT64_MAX);
  const int64_t value = too_big ? INT64_MAX : value_->get<int64_t>();
  if (too_big || value < min || value > max) {
    refuse("expected an integer from " + std::to_string(min) + " to " + std::to_string(max) + ", got " +
           value_->dump());
  }
  return value;
}

double JsonNode::number() const {
  if (!value_->is_number()) expected("a number");
  const double value = value_->get<double>();
  if (!std::isfinite(value)) refuse("not finite");
  return value;
}

bool JsonNode::boolean() const {
  if (!value_->is_boolean()) expected("true or false");
  return value_->get<bool>();
}

std::vector<JsonNode> JsonNode::elements(size_t min_count, size_t max_count) const {
  if (!value_->is_array()) expected("an array");
  if (value_->size() < min_count || value_->size() > max_count) {
    refuse("has " + std::to_string(value_->size()) + " elements, expected " + std::to_string(min_count) +
           " to " + std::to_string(max_count));
  }
  std::vector<JsonNode> nodes;
  nodes.reserve(value_->size());
  for (const Json& element : *value_) {
    nodes.push_back(JsonNode(element, *origin_, path_ + "[" + std::to_string(nodes.size()) + "]"));
  }
  return nodes;
}

std::vector<JsonNode::Member> JsonNode::members(size_t min_count, size_t max_count) const {
  expect_object();
  if (value_->size() < min_count || value_->size() > max_count) {
    refuse("has " + std::to_string(value_->size()) + " members, expected " + std::to_string(min_count) +
           " to " + std::to_string(max_count));
  }
  std::vector<Member> nodes;
  for (const auto& item : value_->items()) nodes.push_back({item.key(), child(item.value(), item.key())});
  return nodes;
}

}  // namespace chiasm::core
