#include "app/device/drivers/network/key.h"

#include <array>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/realtime/private_process.h"

namespace tandem::driver::network {
namespace {

constexpr std::size_t kLeast = 16;  // bytes of a secret
constexpr std::size_t kMost = 4096;

}  // namespace

Key::~Key() {
  if (!secret_.empty()) OPENSSL_cleanse(secret_.data(), secret_.size());
}

bool Key::Read(const std::string& file, std::string& fault) {
  KeepProcessPrivate();
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) {
    fault = file + ": " + std::strerror(errno) +
            "; make a key: (umask 077; openssl rand -hex 32 > " + file + ")";
    return false;
  }
  struct stat about {};
  std::array<std::uint8_t, kMost + 1> room{};
  ssize_t size = -1;
  if (fstat(descriptor, &about) != 0 || !S_ISREG(about.st_mode)) {
    fault = file + " is not a file";
  } else if (about.st_uid != geteuid() || (about.st_mode & 077U) != 0) {
    fault = file + " is readable by others: make it yours alone with chmod 600 " + file;
  } else {
    size = read(descriptor, room.data(), room.size());
    if (size < 0) fault = file + ": " + std::strerror(errno);
  }
  close(descriptor);
  if (size < 0) return false;
  auto end = static_cast<std::size_t>(size);
  while (end > 0 && (room[end - 1] == '\n' || room[end - 1] == '\r' || room[end - 1] == ' ' ||
                     room[end - 1] == '\t')) {
    --end;
  }
  if (end >= kLeast && static_cast<std::size_t>(size) <= kMost) {
    secret_.assign(room.begin(), room.begin() + static_cast<std::ptrdiff_t>(end));
  } else {
    fault = file + ": a key has 16 to 4096 bytes; make one: (umask 077; openssl rand -hex 32 > " +
            file + ")";
  }
  OPENSSL_cleanse(room.data(), room.size());
  return !secret_.empty();
}

bool Key::Make() {
  secret_.resize(32);
  return getrandom(secret_.data(), secret_.size(), 0) == static_cast<ssize_t>(secret_.size());
}

Key::Code Key::CodeOf(std::span<const std::uint8_t> text) const {
  Code code{};
  unsigned int length = 0;
  HMAC(EVP_sha256(), secret_.data(), static_cast<int>(secret_.size()), text.data(), text.size(),
       code.data(), &length);
  return code;
}

bool Key::Holds(std::span<const std::uint8_t> text, std::span<const std::uint8_t> code) const {
  const Code right = CodeOf(text);
  return code.size() == right.size() && CRYPTO_memcmp(code.data(), right.data(), right.size()) == 0;
}

}  // namespace tandem::driver::network
