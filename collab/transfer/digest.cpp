#include "collab/transfer/digest.h"

#include <openssl/evp.h>

#include "engine/base/check.h"
#include "engine/base/text/hex.h"

namespace tandem {

struct RunningDigest::State {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
};

RunningDigest::RunningDigest() : state_(std::make_unique<State>()) {
  TANDEM_CHECK(state_->context != nullptr);
  TANDEM_CHECK(EVP_DigestInit_ex(state_->context, EVP_sha256(), nullptr) == 1);
}

RunningDigest::~RunningDigest() {
  EVP_MD_CTX_free(state_->context);
}

void RunningDigest::Add(std::span<const char> bytes) {
  TANDEM_CHECK(EVP_DigestUpdate(state_->context, bytes.data(), bytes.size()) == 1);
}

FileDigest RunningDigest::Value() {
  FileDigest digest{};
  TANDEM_CHECK(EVP_DigestFinal_ex(state_->context, digest.data(), nullptr) == 1);
  return digest;
}

FileDigest FileDigestOf(std::span<const char> bytes) {
  RunningDigest running;
  running.Add(bytes);
  return running.Value();
}

std::string HexOf(const FileDigest& digest) {
  return HexOfBytes(digest);
}

}  // namespace tandem
