// minisign's keys and signatures by libsodium: reading, verifying, signing.
#include "core/minisign.h"

#include <sodium.h>

#include <algorithm>

#include "core/status.h"

namespace chiasm::core {
namespace {

constexpr std::string_view kUntrusted = "untrusted comment: ", kTrusted = "trusted comment: ";

constexpr size_t kKeySize = 42;  // "Ed", the number, the key

using KeyId = std::array<unsigned char, 8>;

template <size_t N>
std::string encode(const std::array<unsigned char, N>& bytes) {
  std::array<char, sodium_base64_ENCODED_LEN(N, sodium_base64_VARIANT_ORIGINAL)> text;
  return sodium_bin2base64(text.data(), text.size(), bytes.data(), N, sodium_base64_VARIANT_ORIGINAL);
}

/** Decodes base64 of exactly `N` bytes; false for anything else. */
template <size_t N>
bool decode(std::string_view text, std::array<unsigned char, N>& bytes) {
  size_t size = 0;
  return sodium_base642bin(bytes.data(), N, text.data(), text.size(), nullptr, &size, nullptr,
                           sodium_base64_VARIANT_ORIGINAL) == 0 &&
         size == N && encode(bytes) == text;  // libsodium decodes bytes above 127 as other characters
}

/** Takes a line, without its end, off the front of `text`. */
std::string_view take_line(std::string_view& text) {
  const size_t end = std::min(text.find('\n'), text.size());
  std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

bool starts_with(std::string_view text, std::string_view start) {
  return text.substr(0, start.size()) == start;
}

const unsigned char* bytes_of(std::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

/** As minisign prints it. */
std::string text_of(const KeyId& id) {
  std::string text;
  for (size_t i = id.size(); i-- > 0;) {
    for (const int half : {id[i] >> 4, id[i] & 15}) text += "0123456789ABCDEF"[half];
  }
  return text;
}

}  // namespace

PublicKey read_public_key(std::string_view text, const std::string& origin) {
  if (starts_with(text, kUntrusted)) take_line(text);
  std::array<unsigned char, kKeySize> bytes;
  const std::string_view line = take_line(text);
  if (!text.empty() || !decode(line, bytes) || bytes[0] != 'E' || bytes[1] != 'd') {
    fail(CHIASM_INVALID_ARGUMENT, origin +
                                      ": not a minisign public key: expected 56 characters that begin with "
                                      "RW, alone or below a comment");
  }
  PublicKey key;
  std::copy_n(bytes.begin() + 2, key.id.size(), key.id.begin());
  std::copy_n(bytes.begin() + 10, key.key.size(), key.key.begin());
  return key;
}

std::string text_of(const PublicKey& key) {
  std::array<unsigned char, kKeySize> bytes = {'E', 'd'};
  std::copy(key.id.begin(), key.id.end(), bytes.begin() + 2);
  std::copy(key.key.begin(), key.key.end(), bytes.begin() + 10);
  return encode(bytes);
}

std::string verify_signature(std::string_view message, std::string_view signature,
                             const std::vector<PublicKey>& keys, const std::string& origin) {
  std::array<unsigned char, 74> bytes;
  std::array<unsigned char, 64> global;
  std::string_view rest = signature;
  const bool has_comment = starts_with(take_line(rest), kUntrusted);
  const bool has_signature =
      decode(take_line(rest), bytes) && bytes[0] == 'E' && (bytes[1] == 'd' || bytes[1] == 'D');
  std::string_view comment = take_line(rest);
  const bool has_trusted = starts_with(comment, kTrusted), has_global = decode(take_line(rest), global);
  if (!has_comment || !has_signature || !has_trusted || !has_global || !rest.empty()) {
    fail(CHIASM_CORRUPT, origin + ": not a minisign signature");
  }
  comment.remove_prefix(kTrusted.size());

  KeyId id;
  std::copy_n(bytes.begin() + 2, id.size(), id.begin());
  std::array<unsigned char, 64> hash;
  if (bytes[1] == 'D') {
    crypto_generichash(hash.data(), hash.size(), bytes_of(message), message.size(), nullptr, 0);
    message = {reinterpret_cast<const char*>(hash.data()), hash.size()};
  }
  // Ids are numbers that whoever makes a key may choose, so that two keys may have the same
  const auto has_id = [&id](const PublicKey& key) { return key.id == id; };
  if (std::none_of(keys.begin(), keys.end(), has_id))
    fail(CHIASM_UNTRUSTED, origin + ": made by the key " + text_of(id) + ", which is not trusted here");
  const auto key = std::find_if(keys.begin(), keys.end(), [&](const PublicKey& one) {
    return has_id(one) && crypto_sign_verify_detached(bytes.data() + 10, bytes_of(message), message.size(),
                                                      one.key.data()) == 0;
  });
  if (key == keys.end()) {
    fail(CHIASM_UNTRUSTED,
         origin + ": does not fit: what the key " + text_of(id) + " signed is something else");
  }
  std::string both(reinterpret_cast<const char*>(bytes.data()) + 10, 64);
  both += comment;
  if (crypto_sign_verify_detached(global.data(), bytes_of(both), both.size(), key->key.data()) != 0) {
    fail(CHIASM_UNTRUSTED, origin + ": its trusted comment was changed after it was signed");
  }
  return std::string(comment);
}

std::array<unsigned char, 64> sign(std::string_view message,
                                   const std::array<unsigned char, 64>& secret_key) {
  std::array<unsigned char, 64> signature;
  crypto_sign_detached(signature.data(), nullptr, bytes_of(message), message.size(), secret_key.data());
  return signature;
}

}  // namespace chiasm::core
