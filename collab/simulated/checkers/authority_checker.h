#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "collab/simulated/checkers/violations.h"
#include "collab/simulated/network/simulated_session.h"

namespace tandem {

/// Judges from outside which peer answers for each body and in whose hand it is
/// (docs/decisions/0016).
///
/// At each peer, always: its knowledge of the authority for a body changes only to a greater claim.
/// A claim is greater by the later epoch or, within an epoch, by the lower peer. The knowledge may
/// change to a lesser claim where the claimant of the greater is gone or does not go by it. Beside
/// a hostile member it may do so at any time.
///
/// A peer that has stood still for more than 0.5 s publishes no body's pose for the next 0.3 s.
///
/// The rest holds among the peers of a part of the network that is *settled*. Every peer of it has
/// heard every other, uncut and running, for two ways and 0.3 s. No other peer can hear or be heard
/// by any of them.
///
/// - A body that is not shared is in at most one hand.
/// - For such a body, and for a parked body's place, no peer publishes under a smaller claim than
///   another of them has before.
/// - All peers name the same authority, at most two ways and 0.3 s after the newest claim was made.
/// - That authority is one of them, at most a lease, a beat, 0.3 s and two ways after the former
///   authority went. Each peer that came after that adds 1.5 s. The reason is that a peer which
///   never heard of the former authority does not take over, and the next in line waits for that
///   long.
///
/// A way is the longest time that control traffic has lately needed anywhere, re-sends included.
class AuthorityChecker {
 public:
  AuthorityChecker(const WorldModel& model, Violations& violations);

  /// Names the hostile peer. No other peer needs to answer for its bodies.
  void SetHostile(PeerId peer) { hostile_ = peer; }
  /// Judges a frame; call it after every frame.
  void Check(SimulatedSession& session);
  void OnState(PeerId from, const ObjectState& state);
  /// Judges the end, when all is quiet since `quiet_ns`. Every peer names an authority that is here
  /// for every body. All name the same one, except for claims that began then and may not be
  /// settled yet. This finds peers that claim a body above one another for ever, which make new
  /// claims for ever.
  void CheckEnd(SimulatedSession& session, std::int64_t quiet_ns);

 private:
  struct Known {  // claim, as a peer knows or publishes it
    std::uint32_t epoch = 0;
    PeerId peer = 0;
    bool operator<(const Known& b) const {
      return epoch != b.epoch ? epoch < b.epoch : peer > b.peer;
    }
    bool operator==(const Known&) const = default;
  };
  struct Statement {
    PeerId from = 0;
    std::size_t body = 0;
    Known claim;
  };
  struct Part {  // a settled part of the network
    std::vector<std::size_t> members;
    std::vector<std::int64_t> agreed_ns;  // per body: last time when all was well, or of the newest
                                          // claim
    std::vector<std::int64_t> one_ns;     // per body: last time when all named the same peer
    std::vector<Known> greatest;          // per body
    std::vector<Known> stated;            // per body: greatest on the wire since the part is
                                          // settled
    std::vector<std::int64_t> said_ns;    // per body: time since which that peer publishes it
  };

  void CheckClaims(SimulatedSession& session);
  bool MayGoBack(SimulatedSession& session, std::size_t member, std::size_t body);
  std::vector<std::vector<std::size_t>> SettledParts(const SimulatedSession& session);
  void CheckPart(SimulatedSession& session, Part& part);
  void CheckStatements();
  Part* PartOf(PeerId peer);
  /// Returns how many peers of a part came after that peer went.
  std::int64_t CameSince(const Part& part, PeerId gone) const;
  static Known ClaimAt(SimulatedSession& session, std::size_t member, std::size_t body);

  const WorldModel* model_;
  PeerId hostile_ = 0;  // 0: none
  Violations* violations_;
  std::int64_t now_ns_ = 0;
  std::int64_t way_ns_ = 0;
  std::vector<PeerId> ids_;                // indexed by member
  std::vector<std::int64_t> came_ns_;      // indexed by member
  std::vector<std::int64_t> gone_ns_;      // per member: time since which it is not here; 0: it is
  std::vector<std::int64_t> awake_ns_;     // per member: time since which it runs
  std::vector<std::int64_t> halted_ns_;    // per member: time since which it stands; 0: it runs
  std::vector<std::int64_t> silent_ns_;    // per member: time until which it may publish nothing
  std::vector<std::vector<Known>> known_;  // [member][body], a frame ago
  std::vector<Part> parts_;
  std::vector<Statement> stated_;  // published in this frame
};

}  // namespace tandem
