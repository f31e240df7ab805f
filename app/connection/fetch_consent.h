#pragma once

#include <cstdint>
#include <string>

#include "app/connection/session_scene.h"

namespace tandem {

/// Decides for a person with one button whether a scene's files are fetched. The first press
/// consents to small files. A larger scene is refused with its size, and a second press consents to
/// that scene up to that size. Used by one thread at a time.
class FetchConsent {
 public:
  static constexpr std::uint64_t kSmallBytes = 20'000'000;

  /// Returns why the scene may not be fetched yet, as SessionSceneOptions::refuses.
  std::string Refuses(const Sha256& content, const OfferedScene& offered) {
    if (offered.bytes <= kSmallBytes) return {};
    if (content == told_ && offered.bytes <= told_bytes_) return {};
    told_ = content;
    told_bytes_ = offered.bytes;
    return "the window has not fetched the files, because they are large (" + offered.Words() +
           "): press the button again to fetch it";
  }

 private:
  Sha256 told_{};
  std::uint64_t told_bytes_ = 0;
};

}  // namespace tandem
