#include "engine/base/files/sha256.h"

#include <algorithm>
#include <vector>

#include <openssl/evp.h>
#include <tbb/parallel_for.h>

#include "engine/base/check.h"

namespace tandem {

struct RunningSha256::State {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
};

RunningSha256::RunningSha256() : state_(std::make_unique<State>()) {
  TANDEM_CHECK(state_->context != nullptr);
  TANDEM_CHECK(EVP_DigestInit_ex(state_->context, EVP_sha256(), nullptr) == 1);
}

RunningSha256::~RunningSha256() {
  EVP_MD_CTX_free(state_->context);
}

void RunningSha256::AddBytes(const void* data, std::size_t size) {
  TANDEM_CHECK(EVP_DigestUpdate(state_->context, data, size) == 1);
}

void RunningSha256::AddText(std::string_view text) {
  Add(std::uint64_t{text.size()});
  AddBytes(text.data(), text.size());
}

Sha256 RunningSha256::Value() {
  Sha256 digest{};
  TANDEM_CHECK(EVP_DigestFinal_ex(state_->context, digest.data(), nullptr) == 1);
  return digest;
}

Sha256 Sha256Of(std::span<const char> bytes) {
  RunningSha256 running;
  running.Add(bytes);
  return running.Value();
}

Sha256 Sha256OfMany(std::span<const std::byte> bytes) {
  constexpr std::size_t kPiece = 1 << 20;
  std::vector<Sha256> pieces((bytes.size() + kPiece - 1) / kPiece);
  tbb::parallel_for(std::size_t{0}, pieces.size(), [&](std::size_t i) {
    const auto piece = bytes.subspan(i * kPiece, std::min(kPiece, bytes.size() - i * kPiece));
    pieces[i] = Sha256Of({reinterpret_cast<const char*>(piece.data()), piece.size()});
  });
  RunningSha256 whole;
  whole.Add(std::uint64_t{bytes.size()});
  for (const Sha256& piece : pieces) whole.Add(piece);
  return whole.Value();
}

}  // namespace tandem
