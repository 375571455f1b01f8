/** Two bytes choose the symbols' values; the rest is parsed as an expression, or gives an Error. */
#include "core/expression.h"
#include "core/status.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::vector<std::string> names = {"H", "W"};
  constexpr int64_t kValues[] = {0, 1, -1, 2, 1000003, INT64_MAX, INT64_MIN, int64_t{1} << 40};
  if (size < 2) return 0;
  const int64_t symbols[] = {kValues[data[0] % 8], kValues[data[1] % 8]};
  try {
    int64_t value = 0;
    chiasm::core::Expression::parse({reinterpret_cast<const char*>(data) + 2, size - 2}, names)
        .evaluate(symbols, &value);
  } catch (const chiasm::core::Error&) {}
  return 0;
}
