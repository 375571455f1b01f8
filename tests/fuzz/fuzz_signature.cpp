/** Reads any bytes as a signature or a key: only those made by minisign are accepted. */
#include <cstdlib>

#include "core/minisign.h"
#include "core/status.h"

namespace {

using chiasm::core::Error;

const std::string kMessage = "what minisign signed\n";
const std::string kKey = "RWTw5+M+30ejPJL8tKbwCcT38wi9MhKN6gMYCUvWEFLwjJgIr0gKPa8T";
const std::string kTrusted = "trusted comment: of chiasm's tests";
const char* const kSignatures[][2] = {
    {"RUTw5+M+30ejPDH42sj4swmO/JaHMvuaM1bE5T20b5Xa7fKw6tm1wT0sUdg/7ozN/4kU0SMjcCJs2plm7YJWUloJxOHHTBev8go=",
     "uk2JQfRcPVAMOfgZE00m1zXeRj4XKWdcUXZwTCokpOIctLy9+rGC8rGG3gKZ4TUJ0xg3DVbnwRcSpmUfFWs1BA=="},
    {"RWTw5+M+30ejPKxQFdFvOzuNIMsyewv6vt8AOPu2XGu3Lw0hkxNvroFHgJmyLz6ixaKJKepVWGJRVWaMdux1P9yFMeQDVz6SfAc=",
     "/eJnG7uFOQjAAFsVb+Eq80ZbpNrMbCZ3GZ23JvrTkWyIkjN3bzfKLbChOPNaMPjy7sfHZtm4d7+DWzbt+jvICA=="}};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto has = [&text](const std::string& part) { return text.find(part) != std::string::npos; };
  try {
    chiasm::core::verify_signature(kMessage, text, {chiasm::core::read_public_key(kKey, "k")}, "s");
    bool genuine = false;
    for (const auto& lines : kSignatures)
      genuine = genuine || (has(lines[0]) && has(kTrusted) && has(lines[1]));
    if (!genuine) std::abort();
  } catch (const Error&) {}
  try {
    if (!has(chiasm::core::text_of(chiasm::core::read_public_key(text, "k")))) std::abort();
  } catch (const Error&) {}
  return 0;
}
