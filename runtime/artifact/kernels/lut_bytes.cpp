// Bytes looked up in tables of 256 bytes.
#include <array>
#include <cstring>

#include "declared/lut_bytes.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// ((x ^ flip) & keep) + add, modulo 256: a constant, x plus or minus a number, a number minus x, x without
// some of its bits.
struct Form {
  uint8_t flip = 0, keep = 0, add = 0;
  uint8_t operator()(int x) const { return static_cast<uint8_t>(((x ^ flip) & keep) + add); }
};

// A table in which one form describes the entries before `second`, and another the entries from there on:
// thresholds, inversion, solarisation, saturating sums. Each form is a few instructions per vector.
struct TwoForms {
  Form before, after;
  int second = 0;
};

// The number of entries, from `first` on, that the form describes.
int reach(const uint8_t* table, int first, const Form& form) {
  int i = first;
  while (i < 256 && table[i] == form(i)) ++i;
  return i - first;
}

// The form that describes most entries from `first` on.
Form longest(const uint8_t* table, int first) {
  const auto minus = [](int a, int b) { return static_cast<uint8_t>(a - b); };
  const Form forms[] = {{0, 0, table[first]},
                        {0, 255, minus(table[first], first)},
                        {255, 255, minus(table[first], 255 - first)},
                        {0, table[255], 0}};
  return *std::max_element(std::begin(forms), std::end(forms), [&](const Form& a, const Form& b) {
    return reach(table, first, a) < reach(table, first, b);
  });
}

bool find_forms(const uint8_t* table, TwoForms& found) {
  found.before = longest(table, 0);
  found.second = reach(table, 0, found.before);
  if (found.second == 256) {
    found.after = found.before;
    found.second = 0;
    return true;
  }
  found.after = longest(table, found.second);
  return found.second + reach(table, found.second, found.after) == 256;
}

void by_forms(const TwoForms& forms, const uint8_t* x, int64_t n, uint8_t* out) {
  const Form before = forms.before, after = forms.after;
  const auto second = static_cast<uint8_t>(forms.second);
  for_lanes<uint8_t, 4>(n, [=](auto d, auto vectors, int64_t k) {
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    const auto made = [=](const Form& form, auto value) {
      return hn::Add(hn::And(hn::Xor(value, hn::Set(d, form.flip)), hn::Set(d, form.keep)),
                     hn::Set(d, form.add));
    };
    for (int v = 0; v < vectors; ++v) {
      const auto value = hn::LoadU(d, x + k + v * lanes);
      const auto is_after = hn::Eq(hn::Max(value, hn::Set(d, second)), value);
      hn::StoreU(hn::IfThenElse(is_after, made(after, value), made(before, value)), d, out + k + v * lanes);
    }
  });
}

// Looks up each sixteenth of the table by all indices; indices outside of it give 0.
void by_parts(const uint8_t* table, const uint8_t* x, int64_t n, uint8_t* out) {
  for_lanes<uint8_t, 2>(n, [=](auto d, auto vectors, int64_t k) {
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    if constexpr (hn::MaxLanes(d) == 1) {
      out[k] = table[x[k]];
    } else {
      hn::Vec<decltype(d)> value[vectors], sum[vectors];
      for (int v = 0; v < vectors; ++v) {
        value[v] = hn::LoadU(d, x + k + v * lanes);
        sum[v] = hn::Zero(d);
      }
      for (int part = 0; part < 16; ++part) {
        const auto entries = hn::LoadDup128(d, table + 16 * part);
        const auto name = hn::Set(d, static_cast<uint8_t>(16 * part));
        for (int v = 0; v < vectors; ++v) {
          // Below 16 for indices in this part; the highest bit is set for all others.
          const auto index = hn::And(hn::SaturatedAdd(hn::Xor(value[v], name), hn::Set(d, uint8_t{0x70})),
                                     hn::Set(d, uint8_t{0x8F}));
          sum[v] = hn::Or(sum[v], hn::TableLookupBytesOr0(entries, index));
        }
      }
      for (int v = 0; v < vectors; ++v) hn::StoreU(sum[v], d, out + k + v * lanes);
    }
  });
}

}  // namespace

void lut_bytes(const uint8_t* tables, int64_t rows, const uint8_t* x, int64_t n, int64_t values,
               uint8_t* out) {
  constexpr int64_t kPart = 65536;
  const int64_t parts = (values + kPart - 1) / kPart;
  struct Table {
    TwoForms forms;
    bool simple;
  };
  std::vector<Table> known(static_cast<size_t>(rows));
  for (int64_t row = 0; row < rows; ++row) {
    Table& table = known[static_cast<size_t>(row)];
    table.simple = find_forms(tables + 256 * row, table.forms);
  }
#pragma omp parallel for
  for (int64_t i = 0; i < n * parts; ++i) {
    const int64_t image = i / parts, row = image * rows / n, first = i % parts * kPart,
                  count = std::min(kPart, values - first), start = image * values + first;
    const Table& table = known[static_cast<size_t>(row)];
    if (table.simple)
      by_forms(table.forms, x + start, count, out + start);
    else
      by_parts(tables + 256 * row, x + start, count, out + start);
  }
}

// A pixel is written as four bytes, of which the next pixel overwrites the last; the last pixel of a thread's
// part as three.
void lut_pixels(const uint8_t* tables, const uint8_t* x, int64_t n, uint8_t* out) {
  constexpr int64_t kPart = 16384;
  std::array<std::array<uint8_t, 4>, 256> pixels{};
  for (size_t level = 0; level < 256; ++level)
    for (size_t channel = 0; channel < 3; ++channel) pixels[level][channel] = tables[256 * channel + level];
#pragma omp parallel for
  for (int64_t first = 0; first < n; first += kPart) {
    const int64_t last = std::min(first + kPart, n) - 1;
    for (int64_t i = first; i < last; ++i) std::memcpy(out + 3 * i, pixels[x[i]].data(), 4);
    std::memcpy(out + 3 * last, pixels[x[last]].data(), 3);
  }
}

}  // namespace chiasm::kernels
