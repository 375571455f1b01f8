/** Signatures and public keys in minisign's format: Ed25519, of a message or of its BLAKE2b hash. */
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace chiasm::core {

/** The longest signature or key file, in bytes. */
inline constexpr uint64_t kMaxSignatureSize = 16384;

struct PublicKey {
  std::array<unsigned char, 8> id;
  std::array<unsigned char, 32> key;
};

/** Reads a key: its 56 characters, or the text of a key file, whose second line has them. Throws Error
 *  (INVALID_ARGUMENT) that names `origin`. */
PublicKey read_public_key(std::string_view text, const std::string& origin);

/** The key's 56 characters. */
std::string text_of(const PublicKey& key);

/** Checks that one of the keys has signed the message and the signature's trusted comment. Returns the
 *  comment. Throws Error, which names `origin`: CORRUPT if `signature` is no signature file, UNTRUSTED for
 *  everything else. */
std::string verify_signature(std::string_view message, std::string_view signature,
                             const std::vector<PublicKey>& keys, const std::string& origin);

/** Ed25519: the signature of a message by a secret key (seed, then public key), for programs that write
 *  signature files. */
std::array<unsigned char, 64> sign(std::string_view message, const std::array<unsigned char, 64>& secret_key);

}  // namespace chiasm::core
