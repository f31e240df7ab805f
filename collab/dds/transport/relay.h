#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "collab/dds/transport/dds_transport.h"
#include "collab/session/transport.h"
#include "engine/base/result.h"

namespace tandem {

/// Changes a session's options to those under which its relay shows it: a separate session in the
/// next domain, which only its viewers and the relay find.
void GoToRelay(DdsOptions& options);
bool IsBehindRelay(const DdsOptions& options);

/// Passes what it receives as a viewer of a session on to viewers with a separate discovery tag. So
/// the session's peers send each picture once, however many viewers there are. To the viewers the
/// session's peers seem to be there themselves: their views, names, comings and goings, and the
/// scene.
///
/// Its memory is bounded: kMaxRelayed peers, and the one scene that each offers.
///
/// It is an Inbox; the calls of one session may come from several threads.
class Relay : public Inbox {
 public:
  /// Opens the viewers' side; `viewers` are options changed by GoToRelay(). With `secure` its
  /// viewers need keys. The folder is then a relay's (MakeRelayKeys), of other authorities than the
  /// session's own.
  static Result<std::unique_ptr<Relay>> Open(const DdsOptions& viewers);

  /// Says goodbye for all peers that are still here, and leaves.
  virtual void Leave() = 0;
  /// Only says these goodbyes, from any thread: the last act of a program that is ended by force.
  virtual void SayGoodbyes() = 0;
  /// Says that its keys end, as Transport::KeysEnd() does.
  virtual std::string KeysEnd() const = 0;
  virtual std::uint64_t views_passed_on() const = 0;
  /// Returns the number of viewers that read from it.
  virtual std::size_t viewers() const = 0;
};

}  // namespace tandem
