/** Integer expressions over symbolic dimensions: `"H//2 + 1"`. */
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace chiasm::core {

/** The most symbols a manifest may declare, so that their values fit on the stack of a run. */
inline constexpr size_t kMaxSymbols = 64;

/** A parsed expression: integers, symbols, `+ - * //` (floor division), unary minus and parentheses.
 *
 *  Parsed once, evaluated on every run: a postfix program that needs no memory of its own.
 */
class Expression final {
 public:
  /** What went wrong in an evaluation. */
  enum class Fault { none, overflow, division_by_zero };

  Expression() : Expression(0) {}
  explicit Expression(int64_t constant);

  /** Parse `text`, in which each name must be one of `symbols`. Throws Error (CHIASM_CORRUPT) that quotes the
   *  text. */
  static Expression parse(std::string_view text, const std::vector<std::string>& symbols);

  /** The value if symbol i has the value `symbols[i]`. */
  Fault evaluate(const int64_t* symbols, int64_t* value) const noexcept;

  bool is_constant() const { return code_.size() == 1 && code_[0].kind == Kind::constant; }
  bool is_symbol() const { return code_.size() == 1 && code_[0].kind == Kind::symbol; }
  /** The constant's value, or the symbol's index. */
  int64_t operand() const { return code_[0].operand; }
  /** As it was written. */
  const std::string& text() const { return text_; }
  /** The symbols that occur in it, perhaps repeated. */
  std::vector<size_t> symbols() const;

 private:
  friend class ExpressionParser;
  enum class Kind : uint8_t { constant, symbol, add, subtract, multiply, divide, negate };
  struct Instruction {
    Kind kind;
    int64_t operand;
  };

  std::vector<Instruction> code_;
  std::string text_;
};

}  // namespace chiasm::core
