// Parses expressions over dimensions by recursive descent, and evaluates their postfix programs without
// allocating memory.
#include "core/expression.h"

#include <algorithm>
#include <charconv>

#include "core/status.h"

namespace chiasm::core {
namespace {

constexpr size_t kMaxLength = 256;
constexpr int kMaxDepth = 16;  // of parentheses and unary minus
constexpr size_t kMaxStack = 2 * kMaxDepth + 4;

bool is_name_start(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

/** Recursive descent: sum := product (('+' | '-') product)*, product := factor (('*' | '//') factor)*. */
class ExpressionParser final {
 public:
  ExpressionParser(std::string_view text, const std::vector<std::string>& symbols)
      : text_(text), symbols_(symbols) {}

  Expression parse() {
    if (text_.size() > kMaxLength) error("longer than " + std::to_string(kMaxLength) + " characters");
    sum(0);
    skip_space();
    if (at_ < text_.size()) error("unexpected '" + std::string(1, text_[at_]) + "'");
    result_.text_ = std::string(text_);
    return std::move(result_);
  }

 private:
  using Kind = Expression::Kind;

  [[noreturn]] void error(const std::string& what) const {
    fail(CHIASM_CORRUPT, "dimension '" + std::string(text_.substr(0, kMaxLength)) + "': " + what);
  }

  void skip_space() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
  }

  bool accept(std::string_view token) {
    skip_space();
    if (text_.substr(at_, token.size()) != token) return false;
    at_ += token.size();
    return true;
  }

  void emit(Kind kind, int64_t operand = 0) { result_.code_.push_back({kind, operand}); }

  void sum(int depth) {
    product(depth);
    while (true) {
      if (accept("+")) {
        product(depth);
        emit(Kind::add);
      } else if (accept("-")) {
        product(depth);
        emit(Kind::subtract);
      } else {
        return;
      }
    }
  }

  void product(int depth) {
    factor(depth);
    while (true) {
      if (accept("*")) {
        factor(depth);
        emit(Kind::multiply);
      } else if (accept("//")) {
        factor(depth);
        emit(Kind::divide);
      } else {
        return;
      }
    }
  }

  void factor(int depth) {
    if (depth > kMaxDepth) error("nested too deeply");
    if (accept("-")) {
      factor(depth + 1);
      emit(Kind::negate);
    } else if (accept("(")) {
      sum(depth + 1);
      if (!accept(")")) error("missing ')'");
    } else {
      operand();
    }
  }

  void operand() {
    skip_space();
    if (at_ == text_.size()) error("ends where a number or symbol is expected");
    const char first = text_[at_];
    if (is_digit(first)) {
      int64_t value = 0;
      const char* begin = text_.data() + at_;
      const auto [end, fault] = std::from_chars(begin, text_.data() + text_.size(), value);
      if (fault != std::errc()) error("number out of range");
      at_ += static_cast<size_t>(end - begin);
      emit(Kind::constant, value);
    } else if (is_name_start(first)) {
      const size_t begin = at_;
      while (at_ < text_.size() && (is_name_start(text_[at_]) || is_digit(text_[at_]))) ++at_;
      const std::string_view name = text_.substr(begin, at_ - begin);
      const auto found = std::find(symbols_.begin(), symbols_.end(), name);
      if (found == symbols_.end()) error("unknown symbol '" + std::string(name) + "'");
      emit(Kind::symbol, found - symbols_.begin());
    } else {
      error("unexpected '" + std::string(1, first) + "'");
    }
  }

  std::string_view text_;
  const std::vector<std::string>& symbols_;
  size_t at_ = 0;
  Expression result_ = empty();

  static Expression empty() {
    Expression expression;
    expression.code_.clear();
    return expression;
  }
};

Expression::Expression(int64_t constant)
    : code_{{Kind::constant, constant}}, text_(std::to_string(constant)) {}

Expression Expression::parse(std::string_view text, const std::vector<std::string>& symbols) {
  return ExpressionParser(text, symbols).parse();
}

Expression::Fault Expression::evaluate(const int64_t* symbols, int64_t* value) const noexcept {
  // A pending operator keeps at most one value per level of sum and one per level of product on the stack.
  int64_t stack[kMaxStack];
  size_t top = 0;
  for (const Instruction& step : code_) {
    if (step.kind == Kind::constant || step.kind == Kind::symbol) {
      stack[top++] = step.kind == Kind::constant ? step.operand : symbols[step.operand];
      continue;
    }
    if (step.kind == Kind::negate) {
      if (__builtin_sub_overflow(int64_t{0}, stack[top - 1], &stack[top - 1])) return Fault::overflow;
      continue;
    }
    const int64_t b = stack[--top];
    int64_t& a = stack[top - 1];
    bool overflow = false;
    switch (step.kind) {
      case Kind::add: overflow = __builtin_add_overflow(a, b, &a); break;
      case Kind::subtract: overflow = __builtin_sub_overflow(a, b, &a); break;
      case Kind::multiply: overflow = __builtin_mul_overflow(a, b, &a); break;
      default:
        if (b == 0) return Fault::division_by_zero;
        if (a == INT64_MIN && b == -1) return Fault::overflow;
        a = a / b - ((a % b != 0 && (a < 0) != (b < 0)) ? 1 : 0);
    }
    if (overflow) return Fault::overflow;
  }
  *value = stack[0];
  return Fault::none;
}

std::vector<size_t> Expression::symbols() const {
  std::vector<size_t> found;
  for (const Instruction& step : code_) {
    if (step.kind == Kind::symbol) found.push_back(static_cast<size_t>(step.operand));
  }
  return found;
}

}  // namespace chiasm::core
