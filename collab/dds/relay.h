#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "collab/dds/dds_transport.h"
#include "collab/transport.h"
#include "engine/base/result.h"

namespace tandem {

/// Makes of a session's options those of where its relay shows it: a session of its own in the next
/// domain, found by its viewers and the relay alone.
void GoToRelay(DdsOptions& options);
bool IsBehindRelay(const DdsOptions& options);

/// Gives what it hears as a viewer of a session on to viewers in a discovery tag of their own, so
/// that the session's peers send each picture once, however many look on. To its viewers the
/// session's peers seem to be there themselves: their views, names, comings and goings, and the
/// scene.
///
/// What it keeps is bounded: kMaxRelayed peers, and of each the one scene that it offers.
///
/// It is an Inbox; the calls of one session may come from several threads.
class Relay : public Inbox {
 public:
  /// The viewers' side; `viewers` are GoToRelay()'s. With `secure` its viewers need keys: the
  /// folder is a relay's (MakeRelayKeys), of authorities that are not the session's own.
  static Result<std::unique_ptr<Relay>> Open(const DdsOptions& viewers);

  /// Says goodbye for all that are still here.
  virtual void Leave() = 0;
  /// The same and no more, from any thread: what is left to do when the program is ended by force.
  virtual void SayGoodbyes() = 0;
  /// Says that its keys end now, as Transport::KeysEnd() does.
  virtual std::string KeysEnd() const = 0;
  virtual std::uint64_t views_passed_on() const = 0;
  /// Viewers that read them now.
  virtual std::size_t viewers() const = 0;
};

}  // namespace tandem
