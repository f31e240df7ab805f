#include "app/invite/tls_endpoint.h"

#include <algorithm>
#include <utility>

#include <openssl/crypto.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include "engine/base/check.h"
#include "engine/realtime/private_process.h"

namespace tandem {

// not in the anonymous namespace, since members of classes in the header use it
template <auto Free>
struct TlsFreed {
  template <typename T>
  void operator()(T* object) const {
    Free(object);
  }
};
using TlsContextPointer = std::unique_ptr<SSL_CTX, TlsFreed<SSL_CTX_free>>;
using TlsKeyPointer = std::unique_ptr<EVP_PKEY, TlsFreed<EVP_PKEY_free>>;
using TlsCertificatePointer = std::unique_ptr<X509, TlsFreed<X509_free>>;

namespace {

constexpr std::string_view kBindingLabel = "EXPORTER-tandem-enrolment-1";
constexpr long kValidFor = 7L * 86'400;  // s; longer than any listener is open

Error NoTls() {
  return Error{"OpenSSL makes no key for the listener: see its installation"};
}

TlsContextPointer NewContext(const SSL_METHOD* method) {
  TlsContextPointer context(SSL_CTX_new(method));
  if (!context || SSL_CTX_set_min_proto_version(context.get(), TLS1_3_VERSION) != 1 ||
      SSL_CTX_set_max_proto_version(context.get(), TLS1_3_VERSION) != 1) {
    return nullptr;
  }
  // each connection is made once, so sessions are not resumed
  SSL_CTX_set_num_tickets(context.get(), 0);
  SSL_CTX_set_session_cache_mode(context.get(), SSL_SESS_CACHE_OFF);
  return context;
}

/// Returns zeros without a certificate.
Secret128 DigestOf(const X509* certificate) {
  Secret128 half{};
  std::array<unsigned char, EVP_MAX_MD_SIZE> whole{};
  unsigned size = 0;
  if (certificate != nullptr && X509_digest(certificate, EVP_sha256(), whole.data(), &size) == 1 &&
      size >= half.size()) {
    std::copy_n(whole.begin(), half.size(), half.begin());
  }
  return half;
}

TlsCertificatePointer CertificateFor(EVP_PKEY* key) {
  TlsCertificatePointer certificate(X509_new());
  if (!certificate) return nullptr;
  X509* const made = certificate.get();
  X509_NAME* const name = X509_get_subject_name(made);
  const auto* const words = reinterpret_cast<const unsigned char*>("Tandem invitation");
  const bool done = X509_set_version(made, X509_VERSION_3) == 1 &&
                    ASN1_INTEGER_set(X509_get_serialNumber(made), 1) == 1 &&
                    X509_gmtime_adj(X509_getm_notBefore(made), -kValidFor) != nullptr &&
                    X509_gmtime_adj(X509_getm_notAfter(made), kValidFor) != nullptr &&
                    X509_set_pubkey(made, key) == 1 &&
                    X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, words, -1, -1, 0) == 1 &&
                    X509_set_issuer_name(made, name) == 1 && X509_sign(made, key, EVP_sha256()) > 0;
  return done ? std::move(certificate) : nullptr;
}

}  // namespace

Result<Secret128> NewSecret() {
  KeepProcessPrivate();
  Secret128 secret{};
  if (RAND_bytes(secret.data(), static_cast<int>(secret.size())) != 1) {
    return Error{"the system gives no random bytes"};
  }
  return secret;
}

Digest256 KeyedDigest(const Secret128& secret, std::string_view text) {
  Digest256 digest{};
  unsigned size = 0;
  const auto* const bytes = reinterpret_cast<const unsigned char*>(text.data());
  TANDEM_CHECK(HMAC(EVP_sha256(), secret.data(), static_cast<int>(secret.size()), bytes,
                    text.size(), digest.data(), &size) != nullptr &&
               size == digest.size());
  return digest;
}

bool AreSame(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

struct TlsIdentity::Context {
  TlsContextPointer tls;
};

Result<TlsIdentity> TlsIdentity::Make() {
  const TlsKeyPointer key(EVP_EC_gen("P-256"));
  if (!key) return NoTls();
  const TlsCertificatePointer certificate = CertificateFor(key.get());
  TlsContextPointer tls = NewContext(TLS_server_method());
  if (!certificate || !tls || SSL_CTX_use_certificate(tls.get(), certificate.get()) != 1 ||
      SSL_CTX_use_PrivateKey(tls.get(), key.get()) != 1) {
    return NoTls();
  }
  TlsIdentity identity;
  identity.digest_ = DigestOf(certificate.get());
  identity.context_ = std::make_shared<Context>(Context{std::move(tls)});
  return identity;
}

struct TlsEndpoint::State {
  TlsContextPointer own;                         // set in a client
  std::shared_ptr<TlsIdentity::Context> shared;  // set in a server
  std::unique_ptr<SSL, TlsFreed<SSL_free>> tls;
  BIO* in = nullptr;  // from the network; `tls` owns both BIOs
  BIO* out = nullptr;
};

TlsEndpoint::TlsEndpoint(std::unique_ptr<State> state) : state_(std::move(state)) {
  SSL_CTX* const context = state_->own ? state_->own.get() : state_->shared->tls.get();
  state_->tls.reset(SSL_new(context));
  state_->in = BIO_new(BIO_s_mem());
  state_->out = BIO_new(BIO_s_mem());
  TANDEM_CHECK(state_->tls && state_->in != nullptr && state_->out != nullptr);
  SSL_set_bio(state_->tls.get(), state_->in, state_->out);
  // the client checks the certificate's digest (others_digest()) instead
  SSL_set_verify(state_->tls.get(), SSL_VERIFY_NONE, nullptr);
}

TlsEndpoint::TlsEndpoint(TlsEndpoint&&) noexcept = default;
TlsEndpoint& TlsEndpoint::operator=(TlsEndpoint&&) noexcept = default;
TlsEndpoint::~TlsEndpoint() = default;

TlsEndpoint TlsEndpoint::Server(const TlsIdentity& identity) {
  auto state = std::make_unique<State>();
  state->shared = identity.context_;
  TlsEndpoint end(std::move(state));
  SSL_set_accept_state(end.state_->tls.get());
  return end;
}

TlsEndpoint TlsEndpoint::Client() {
  auto state = std::make_unique<State>();
  state->own = NewContext(TLS_client_method());
  TANDEM_CHECK(state->own != nullptr);
  TlsEndpoint end(std::move(state));
  SSL_set_connect_state(end.state_->tls.get());
  end.Advance();
  return end;
}

void TlsEndpoint::Advance() {
  if (open_ || failed_) return;
  ERR_clear_error();  // SSL_get_error() reads this thread's queue of errors
  const int done = SSL_do_handshake(state_->tls.get());
  open_ = done == 1;
  failed_ = !open_ && SSL_get_error(state_->tls.get(), done) != SSL_ERROR_WANT_READ;
}

void TlsEndpoint::Receive(std::span<const char> bytes) {
  if (failed_) return;
  if (BIO_write(state_->in, bytes.data(), static_cast<int>(bytes.size())) !=
      static_cast<int>(bytes.size())) {
    failed_ = true;
  }
  Advance();
}

std::string TlsEndpoint::TakeToSend() {
  std::string bytes(BIO_ctrl_pending(state_->out), '\0');
  if (bytes.empty()) return bytes;
  const int got = BIO_read(state_->out, bytes.data(), static_cast<int>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(std::max(got, 0)));
  return bytes;
}

Secret128 TlsEndpoint::others_digest() const {
  if (!open_) return {};
  const TlsCertificatePointer certificate(SSL_get1_peer_certificate(state_->tls.get()));
  return DigestOf(certificate.get());
}

Digest256 TlsEndpoint::Binding() const {
  Digest256 bytes{};
  TANDEM_CHECK(open_ && SSL_export_keying_material(state_->tls.get(), bytes.data(), bytes.size(),
                                                   kBindingLabel.data(), kBindingLabel.size(),
                                                   nullptr, 0, 0) == 1);
  return bytes;
}

void TlsEndpoint::Say(std::string_view text) {
  if (!open_ || failed_ || text.empty()) return;
  std::size_t written = 0;
  ERR_clear_error();
  if (SSL_write_ex(state_->tls.get(), text.data(), text.size(), &written) != 1) failed_ = true;
}

std::string TlsEndpoint::Hear() {
  std::string text;
  std::array<char, 4096> buffer;
  while (open_ && !failed_) {
    std::size_t size = 0;
    ERR_clear_error();
    const int done = SSL_read_ex(state_->tls.get(), buffer.data(), buffer.size(), &size);
    if (done == 1) {
      text.append(buffer.data(), size);
      continue;
    }
    if (SSL_get_error(state_->tls.get(), done) != SSL_ERROR_WANT_READ) failed_ = true;
    break;
  }
  return text;
}

void TlsEndpoint::Close() {
  if (open_ && !failed_) SSL_shutdown(state_->tls.get());
}

}  // namespace tandem
