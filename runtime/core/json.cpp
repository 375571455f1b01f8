// Parses JSON with limits that untrusted text needs: of depth, of memory, and no key twice in an object.
#include "core/json.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/status.h"

namespace chiasm::core {
namespace {

constexpr size_t kMaxDepth = 32;

using Json = nlohmann::json;

/** Builds a document from the parser's events. The parser's own builder accepts repeated keys; and if memory
 *  runs out, it destroys the partial document, which needs memory (JsonDocument). */
class Builder final : public Json::json_sax_t {
 public:
  Builder(Json& root, const std::string& origin) : root_(root), origin_(origin) {}

  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(int64_t value) override { return add(value); }
  bool number_unsigned(uint64_t value) override { return add(value); }
  bool number_float(double value, const std::string&) override { return add(value); }
  bool string(std::string& value) override { return add(std::move(value)); }
  bool binary(Json::binary_t&) override { return false; }  // JSON has none
  bool start_object(size_t) override { return open(Json::value_t::object); }
  bool start_array(size_t) override { return open(Json::value_t::array); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(std::string& key) override {
    if (open_.back()->contains(key)) {
      fail(CHIASM_CORRUPT, origin_ + ": the key '" + printable(key) + "' occurs twice");
    }
    key_ = std::move(key);
    return true;
  }
  bool parse_error(size_t, const std::string&, const Json::exception& error) override {
    fail(CHIASM_CORRUPT, origin_ + ": not JSON: " + printable(error.what()));
  }

 private:
  bool add(Json value) {
    place(std::move(value));
    return true;
  }
  Json& place(Json value) {
    if (open_.empty()) return root_ = std::move(value);
    if (open_.back()->is_object()) return (*open_.back())[key_] = std::move(value);
    open_.back()->push_back(std::move(value));
    return open_.back()->back();
  }
  bool open(Json::value_t type) {
    if (open_.size() == kMaxDepth)
      fail(CHIASM_CORRUPT, origin_ + ": nested deeper than " + std::to_string(kMaxDepth) + " levels");
    open_.push_back(&place(type));
    return true;
  }
  bool close() {
    open_.pop_back();
    return true;
  }

  Json& root_;
  const std::string& origin_;
  std::vector<Json*> open_;  // outermost first; an open object or array does not move
  std::string key_;
};

/** Empties what `value` holds. */
void take_apart(Json& value) noexcept {
  if (!value.is_structured()) return;
  for (Json& element : value) take_apart(element);
  value.clear();
}

}  // namespace

JsonDocument::~JsonDocument() { take_apart(value); }

JsonDocument parse_json(std::string_view text, const std::string& origin) {
  // The parser would end at a zero byte, and other readers would see another document behind it.
  if (text.find('\0') != std::string_view::npos) fail(CHIASM_CORRUPT, origin + ": not JSON: has a zero byte");
  JsonDocument document;
  Builder builder(document.value, origin);
  Json::sax_parse(text.begin(), text.end(), &builder);
  return document;
}

void JsonNode::refuse(const std::string& what, chiasm_code code) const {
  fail(code, *origin_ + ": " + printable((path_.empty() ? "" : path_ + ": ") + what));
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
