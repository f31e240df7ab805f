#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "collab/transport.h"
#include "engine/base/result.h"

namespace tandem {

struct RelayOptions {
  std::string session;
  std::uint32_t domain = 42;  // the session's; the relay's own viewers are in the next
  std::string interface;
};

/// Where the viewers of a relay are: a session of its own, found by them and the relay alone.
std::string RelaySession(const std::string& session);
inline std::uint32_t RelayDomain(std::uint32_t domain) {
  return domain + 1;
}

/// Gives what it hears as a viewer of a session on to viewers in a discovery tag of their own, so
/// that the session's peers send each picture once, however many look on. To its viewers the
/// session's peers seem to be there themselves: their views, names, comings and goings, and the
/// scene.
///
/// It is an Inbox; the calls of one session may come from several threads.
class Relay : public Inbox {
 public:
  /// The viewers' side.
  static Result<std::unique_ptr<Relay>> Open(const RelayOptions& options);

  /// Says goodbye for all that are still here.
  virtual void Leave() = 0;
  virtual std::uint64_t views_passed_on() const = 0;
  /// Viewers that read them now.
  virtual std::size_t viewers() const = 0;
};

}  // namespace tandem
