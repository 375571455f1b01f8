/** Whose bundles this process may run: signatures, trusted keys, policies. With fake backends. */
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sodium.h>

#include <cstdlib>
#include <filesystem>
#include <new>

#include "chiasm/chiasm.hpp"
#include "core/minisign.h"
#include "core/status.h"
#include "support.h"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // whose allocations are their own
#define CHIASM_ALLOCATIONS_FAIL

/** The number of this thread's allocations that succeed before one fails; negative: none fails. */
static thread_local int allocations_left = -1;

void* operator new(std::size_t size) {
  void* const memory = allocations_left >= 0 && allocations_left-- == 0 ? nullptr : std::malloc(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif

namespace chiasm::testing {
namespace {

using Json = nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

// Signatures of this message by the program minisign 0.11, with its own key, hashed and not hashed.
const std::string kMessage = "what minisign signed\n";
const std::string kKey = "RWTw5+M+30ejPJL8tKbwCcT38wi9MhKN6gMYCUvWEFLwjJgIr0gKPa8T";
const std::string kHashed =
    "untrusted comment: signature from minisign secret key\n"
    "RUTw5+M+30ejPDH42sj4swmO/JaHMvuaM1bE5T20b5Xa7fKw6tm1wT0sUdg/7ozN/4kU0SMjcCJs2plm7YJWUloJxOHHTBev8go=\n"
    "trusted comment: of chiasm's tests\n"
    "uk2JQfRcPVAMOfgZE00m1zXeRj4XKWdcUXZwTCokpOIctLy9+rGC8rGG3gKZ4TUJ0xg3DVbnwRcSpmUfFWs1BA==\n";
const std::string kLegacy =
    "untrusted comment: signature from minisign secret key\n"
    "RWTw5+M+30ejPKxQFdFvOzuNIMsyewv6vt8AOPu2XGu3Lw0hkxNvroFHgJmyLz6ixaKJKepVWGJRVWaMdux1P9yFMeQDVz6SfAc=\n"
    "trusted comment: of chiasm's tests\n"
    "/eJnG7uFOQjAAFsVb+Eq80ZbpNrMbCZ3GZ23JvrTkWyIkjN3bzfKLbChOPNaMPjy7sfHZtm4d7+DWzbt+jvICA==\n";

std::string verify(const std::string& message, const std::string& signature, const std::string& key = kKey) {
  return core::verify_signature(message, signature, {core::read_public_key(key, "k")}, "s");
}

/** A key pair of this test, and its signatures, in minisign's format. */
class Signer final {
 public:
  explicit Signer(unsigned char number) {
    const std::array<unsigned char, 32> seed = {number, 1, 2, 3};
    crypto_sign_seed_keypair(public_.key.data(), secret_.data(), seed.data());
    public_.id = {number, 7, 7, 7, 7, 7, 7, 7};
  }

  std::string key() const { return core::text_of(public_); }

  std::string operator()(const std::string& message, const std::string& comment = "a comment") const {
    unsigned char hash[64];
    crypto_generichash(hash, sizeof hash, reinterpret_cast<const unsigned char*>(message.data()),
                       message.size(), nullptr, 0);
    const std::string signature = raw(std::string(reinterpret_cast<const char*>(hash), sizeof hash));
    std::string head = "ED";
    head.append(reinterpret_cast<const char*>(public_.id.data()), public_.id.size());
    return "untrusted comment: x\n" + base64(head + signature) + "\ntrusted comment: " + comment + "\n" +
           base64(raw(signature + comment)) + "\n";
  }

  void sign_bundle(const std::string& path) const {
    write_text(path + "/manifest.json.minisig", (*this)(read_text(path + "/manifest.json")));
  }

 private:
  std::string raw(const std::string& message) const {
    const auto signature = core::sign(message, secret_);
    return std::string(signature.begin(), signature.end());
  }

  static std::string base64(const std::string& bytes) {
    std::string text(sodium_base64_ENCODED_LEN(bytes.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
    sodium_bin2base64(text.data(), text.size(), reinterpret_cast<const unsigned char*>(bytes.data()),
                      bytes.size(), sodium_base64_VARIANT_ORIGINAL);
    text.pop_back();
    return text;
  }

  std::array<unsigned char, 64> secret_;
  core::PublicKey public_;
};

TEST(Signature, OfMinisignIsAccepted) {
  EXPECT_EQ(verify(kMessage, kHashed), "of chiasm's tests");
  EXPECT_EQ(verify(kMessage, kLegacy), "of chiasm's tests");
  EXPECT_EQ(verify(kMessage, kHashed, "untrusted comment: any\n" + kKey + "\n"), "of chiasm's tests");
  EXPECT_EQ(core::text_of(core::read_public_key(kKey, "k")), kKey);
}

TEST(Signature, CoversEveryByte) {
  const auto fails = [](const std::string& message, const std::string& signature) {
    try {
      verify(message, signature);
      return false;
    } catch (const core::Error& error) {
      return error.code() == CHIASM_UNTRUSTED || error.code() == CHIASM_CORRUPT;
    }
  };
  for (const std::string& signature : {kHashed, kLegacy}) {
    for (size_t i = 0; i < kMessage.size(); ++i) {
      std::string other = kMessage;
      other[i] ^= 1;
      EXPECT_TRUE(fails(other, signature)) << i;
    }
    EXPECT_TRUE(fails(kMessage + " ", signature));
    EXPECT_TRUE(fails("", signature));
    // From the second line on, every byte counts except the last line's end; the first line is an untrusted
    // comment.
    for (size_t i = signature.find('\n') + 1; i + 1 < signature.size(); ++i) {
      std::string other = signature;
      other[i] ^= 1;
      EXPECT_TRUE(fails(kMessage, other)) << i << " of " << signature;
      EXPECT_TRUE(fails(kMessage, signature.substr(0, i))) << i << " of " << signature;
    }
  }
}

TEST(Signature, SaysWhatIsWrong) {
  const Signer one(1), two(2);
  const auto says = [&](chiasm_code code, const std::string& signature, const std::string& key) {
    return refusal<core::Error>(code, [&] { verify("m", signature, key); });
  };
  EXPECT_EQ(says(CHIASM_UNTRUSTED, one("m"), two.key()),
            "s: made by the key 0707070707070701, which is not trusted here");
  EXPECT_THAT(says(CHIASM_UNTRUSTED, one("n"), one.key()), HasSubstr("s: does not fit"));
  std::string changed = one("m");
  changed.replace(changed.find("a comment"), 1, "b");
  EXPECT_THAT(says(CHIASM_UNTRUSTED, changed, one.key()), HasSubstr("its trusted comment was changed"));
  for (const std::string& text :
       {std::string(), std::string("x"), std::string(5000, '\n'), one("m") + "more", one("m").substr(1)}) {
    EXPECT_EQ(says(CHIASM_CORRUPT, text, one.key()), "s: not a minisign signature");
  }
}

TEST(Signature, AnyOfTheKeysWithItsIdMayHaveMadeIt) {
  const Signer one(1), two(2);
  const core::PublicKey mine = core::read_public_key(one.key(), "k");
  core::PublicKey other = core::read_public_key(two.key(), "k");
  other.id = mine.id;
  EXPECT_EQ(core::verify_signature("m", one("m"), {other, mine}, "s"),
            core::verify_signature("m", one("m"), {mine, other}, "s"));
  EXPECT_THAT(
      refusal<core::Error>(CHIASM_UNTRUSTED, [&] { core::verify_signature("m", one("m"), {other}, "s"); }),
      HasSubstr("s: does not fit"));
}

TEST(Signature, KeysAreReadStrictly) {
  for (const std::string& text :
       {std::string(), std::string("RW"), kKey.substr(1), kKey + "A", kKey + "\nmore", "\n" + kKey,
        "SW" + kKey.substr(2), std::string("untrusted comment: only"),
        kKey.substr(0, 13) + "\xae\xb3\xc7\x8b" + kKey.substr(17)}) {  // which libsodium accepts as base64
    EXPECT_THAT(refusal<core::Error>(CHIASM_INVALID_ARGUMENT, [&] { core::read_public_key(text, "k"); }),
                HasSubstr("k: not a minisign public key"));
  }
}

class Policy : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string path_ = write_bundle(folder_);
  Signer signer_{1}, stranger_{2};

  Method load(const LoadOptions& options = {}) const {
    return Bundle::open(path_).method("forward", options);
  }
  std::string refused(chiasm_code code) {
    return refusal(code, [&] { load(); });
  }
};

TEST_F(Policy, AnyIsTheDefault) {
  EXPECT_EQ(get_trust(), TrustPolicy::Any);
  EXPECT_EQ(load().backend(), "native");
}

TEST_F(Policy, SignedTakesWhatATrustedKeyHasSigned) {
  set_trust(TrustPolicy::Signed, {stranger_.key(), signer_.key()});
  EXPECT_EQ(get_trust(), TrustPolicy::Signed);
  signer_.sign_bundle(path_);
  EXPECT_EQ(load().backend(), "native");
  EXPECT_EQ(Bundle::open(path_).self_test(LoadOptions().with_backend("onnx")).at(0).result,
            SelfTestRow::Result::Passed);
}

TEST_F(Policy, SignedRefusesAllElse) {
  set_trust(TrustPolicy::Signed, {signer_.key()});
  EXPECT_THAT(refused(CHIASM_UNTRUSTED), AllOf(HasSubstr("is not signed"), HasSubstr("chiasm sign")));
  stranger_.sign_bundle(path_);
  EXPECT_THAT(refused(CHIASM_UNTRUSTED), HasSubstr("which is not trusted here"));
  signer_.sign_bundle(path_);
  const std::string good = read_text(path_ + "/manifest.json");
  std::string changed = good;
  changed.replace(changed.find("scales"), 1, "S");
  write_text(path_ + "/manifest.json", changed);
  EXPECT_THAT(refused(CHIASM_UNTRUSTED), HasSubstr("does not fit"));
  // An unsigned manifest is not even read.
  write_text(path_ + "/manifest.json", "{");
  EXPECT_THAT(refused(CHIASM_UNTRUSTED), HasSubstr("does not fit"));
  write_text(path_ + "/manifest.json", good);
  write_text(path_ + "/manifest.json.minisig", std::string(20000, 'x'));
  EXPECT_THAT(refused(CHIASM_CORRUPT), HasSubstr("manifest.json.minisig: has 20000 bytes"));
}

TEST_F(Policy, SignedCoversArtifactsAndDocuments) {
  const std::string parts = "{\"parts\": []}";
  write_bundle(folder_, [&](Json& m) {
    m["schema_version"] = 2;
    m["documents"]["sbom"] = {
        {"file", "sbom.cdx.json"}, {"size", parts.size()}, {"sha256", sha256_of(parts)}};
  });
  write_text(path_ + "/sbom.cdx.json", parts);
  signer_.sign_bundle(path_);
  set_trust(TrustPolicy::Signed, {signer_.key()});
  EXPECT_EQ(load().backend(), "native");
  const std::string native = path_ + "/" + load().artifact();
  write_text(native, "scale 9");
  EXPECT_THAT(refused(CHIASM_CORRUPT), HasSubstr("changed since the bundle was made"));
  write_text(native, "scale 2");
  write_text(path_ + "/sbom.cdx.json", "{\"parts\": {}}");
  EXPECT_THAT(refused(CHIASM_CORRUPT), HasSubstr("sbom.cdx.json: changed"));
}

TEST_F(Policy, CountsForBundlesThatWereOpenBefore) {
  const Bundle before = Bundle::open(path_);
  set_trust(TrustPolicy::Signed, {signer_.key()});
  EXPECT_THAT(refusal(CHIASM_UNTRUSTED, [&] { before.method("forward"); }), HasSubstr("is not signed"));
  // The content that was read at that time counts.
  signer_.sign_bundle(path_);
  EXPECT_THAT(refusal(CHIASM_UNTRUSTED, [&] { before.method("forward"); }), HasSubstr("is not signed"));
}

TEST_F(Policy, WhatIsRunIsWhatWasSigned) {
  signer_.sign_bundle(path_);
  set_trust(TrustPolicy::Signed, {signer_.key()});
  const Bundle open = Bundle::open(path_);
  set_artifact(path_, "forward.v3.so",
               "scale 9");  // manifest and artifact, both replaced, after the signature was checked
  set_artifact(path_, "forward.v4.so", "scale 9");
  EXPECT_THAT(refusal(CHIASM_CORRUPT, [&] { open.method("forward"); }),
              HasSubstr("changed since the bundle was made"));
}

TEST_F(Policy, DataOnlyLeavesStandardOperators) {
  set_trust(TrustPolicy::DataOnly);
  EXPECT_EQ(load().artifact(), "forward.float32.onnx");
  for (const char* backend : {"native", "torch"}) {
    EXPECT_THAT(refusal(CHIASM_UNTRUSTED, [&] { load(LoadOptions().with_backend(backend)); }),
                HasSubstr("the trust policy is 'data_only'"));
  }
  int ran = 0, left_out = 0;
  for (const SelfTestRow& row : Bundle::open(path_).self_test()) {
    ran += row.result == SelfTestRow::Result::Passed ? 1 : 0;
    left_out += row.result == SelfTestRow::Result::NotRun ? 1 : 0;
    EXPECT_EQ(row.result == SelfTestRow::Result::Passed, row.backend == "onnx") << row.message;
  }
  EXPECT_EQ(ran, 1);
  EXPECT_EQ(left_out, 3);
}

TEST_F(Policy, DataOnlyLeavesOutTheFusedForm) {
  write_bundle(folder_, [&](Json& m) {
    Json fused = m["methods"]["forward"]["artifacts"][3];
    fused["function"] = "test_scale";
    fused["file"] = "forward.float32.fused.onnx";
    m["methods"]["forward"]["artifacts"].push_back(fused);
  });
  write_text(path_ + "/forward.float32.fused.onnx", artifact_content("x.onnx", "scale 2"));
  const LoadOptions onnx = LoadOptions().with_backend("onnx");
  set_trust(TrustPolicy::DataOnly);
  EXPECT_EQ(load(onnx).artifact(), "forward.float32.onnx");
}

TEST_F(Policy, IsFrozenByTheFirstLoad) {
  Bundle::open(path_);
  set_trust(TrustPolicy::DataOnly);
  set_trust(TrustPolicy::Any);  // opening loads no artifact
  load();
  EXPECT_THAT(refusal(CHIASM_FAILED_PRECONDITION, [&] { set_trust(TrustPolicy::Signed, {signer_.key()}); }),
              HasSubstr("after the first method was loaded"));
  EXPECT_EQ(get_trust(), TrustPolicy::Any);
}

TEST_F(Policy, IsFrozenByALoadThatFails) {
  EXPECT_THROW(load(LoadOptions().with_backend("torch")), Error);
  refusal(CHIASM_FAILED_PRECONDITION, [] { set_trust(TrustPolicy::DataOnly); });
}

TEST_F(Policy, ComesFromTheEnvironment) {
  ::setenv("CHIASM_TRUST_POLICY", "data_only", 1);
  EXPECT_EQ(get_trust(), TrustPolicy::DataOnly);
  EXPECT_EQ(load().backend(), "onnx");
  ::setenv("CHIASM_TRUST_POLICY", "any", 1);  // too late
  EXPECT_EQ(get_trust(), TrustPolicy::DataOnly);
  EXPECT_EQ(load().backend(), "onnx");
}

TEST_F(Policy, OfTheEnvironmentTakesKeysAndKeyFiles) {
  const std::string file = folder_.write("trusted.pub", "untrusted comment: a key\n" + signer_.key() + "\n");
  ::setenv("CHIASM_TRUST_POLICY", "signed", 1);
  ::setenv("CHIASM_TRUSTED_KEYS", (stranger_.key() + ":" + file).c_str(), 1);
  signer_.sign_bundle(path_);
  EXPECT_EQ(load().backend(), "native");
  std::filesystem::remove(path_ + "/manifest.json.minisig");
  EXPECT_THAT(refused(CHIASM_UNTRUSTED), HasSubstr("is not signed"));
}

TEST_F(Policy, OfTheEnvironmentIsReplacedByTheProgram) {
  ::setenv("CHIASM_TRUST_POLICY", "data_only", 1);
  set_trust(TrustPolicy::Any);
  EXPECT_EQ(load().backend(), "native");
}

TEST_F(Policy, NonsenseInTheEnvironmentLetsNothingRun) {
  ::setenv("CHIASM_TRUST_POLICY", "Signed", 1);
  EXPECT_THAT(refused(CHIASM_INVALID_ARGUMENT),
              HasSubstr("CHIASM_TRUST_POLICY is 'Signed', expected any, signed or data_only"));
  ::setenv("CHIASM_TRUST_POLICY", "signed", 1);
  EXPECT_THAT(refused(CHIASM_INVALID_ARGUMENT), HasSubstr("CHIASM_TRUSTED_KEYS"));
  ::setenv("CHIASM_TRUSTED_KEYS", "/nowhere.pub", 1);
  EXPECT_THAT(refused(CHIASM_NOT_FOUND), HasSubstr("the trusted key /nowhere.pub"));
  const auto* const without = "CHIASM_TRUSTED_KEYS is set and CHIASM_TRUST_POLICY is not";
  ::setenv("CHIASM_TRUST_POLICY", "", 1);
  EXPECT_THAT(refused(CHIASM_INVALID_ARGUMENT), HasSubstr(without));
  ::unsetenv("CHIASM_TRUST_POLICY");
  EXPECT_THAT(refused(CHIASM_INVALID_ARGUMENT), HasSubstr(without));
}

TEST_F(Policy, ArgumentsAreChecked) {
  const chiasm_api& api = *chiasm_get_api(CHIASM_API_VERSION);
  const char* const null_key[] = {nullptr};
  const auto refused = [&](int32_t policy, const char* const* keys, size_t count) {
    return refusal(CHIASM_INVALID_ARGUMENT, [&] { detail::check(api.set_trust(policy, keys, count)); });
  };
  EXPECT_THAT(refused(3, nullptr, 0), HasSubstr("unknown trust policy 3"));
  EXPECT_THAT(refused(-1, nullptr, 0), HasSubstr("unknown trust policy -1"));
  EXPECT_THAT(refused(CHIASM_TRUST_SIGNED, nullptr, 0), HasSubstr("needs a trusted key"));
  EXPECT_THAT(refused(CHIASM_TRUST_SIGNED, nullptr, 1), HasSubstr("keys is NULL"));
  EXPECT_THAT(refused(CHIASM_TRUST_SIGNED, null_key, 1), HasSubstr("a key is NULL"));
  EXPECT_THAT(refused(CHIASM_TRUST_SIGNED, null_key, SIZE_MAX), HasSubstr("at most 1024"));
  EXPECT_THAT(
      refusal(CHIASM_INVALID_ARGUMENT, [&] { detail::check(api.get_trust(nullptr, nullptr, nullptr)); }),
      HasSubstr("policy is NULL"));
  set_trust(TrustPolicy::Signed, {signer_.key()});
  int32_t policy = 0;
  const char* const* keys = nullptr;
  size_t count = 0;
  detail::check(api.get_trust(&policy, &keys, &count));
  ASSERT_EQ(count, 1u);
  EXPECT_EQ(keys[0], signer_.key());
}

#ifdef CHIASM_ALLOCATIONS_FAIL
TEST_F(Policy, KeysAreWholeAfterALackOfMemory) {
  const chiasm_api& api = *chiasm_get_api(CHIASM_API_VERSION);
  int32_t code = CHIASM_OUT_OF_MEMORY;
  int failures = 0;
  for (; code != CHIASM_OK && failures < 100; ++failures) {
    // others each time: keys that were once given out need no memory again
    const std::vector<std::string> expected = {Signer(static_cast<unsigned char>(failures)).key(),
                                               Signer(static_cast<unsigned char>(100 + failures)).key()};
    set_trust(TrustPolicy::Signed, expected);
    int32_t policy = 0;
    const char* const* keys = nullptr;
    size_t count = 0;
    allocations_left = failures;
    chiasm_status* const status = api.get_trust(&policy, &keys, &count);
    allocations_left = -1;
    code = api.status_code(status);
    api.status_free(status);
    if (code != CHIASM_OK) {
      EXPECT_EQ(code, CHIASM_OUT_OF_MEMORY);
      detail::check(api.get_trust(&policy, &keys, &count));
    }
    ASSERT_EQ(count, 2u);
    ASSERT_NE(keys, nullptr) << "after " << failures << " allocations";
    for (size_t i = 0; i < count; ++i) EXPECT_EQ(keys[i], expected[i]) << "after " << failures;
  }
  EXPECT_EQ(code, CHIASM_OK);
  EXPECT_GT(failures, 5);
}
#endif

}  // namespace
}  // namespace chiasm::testing
