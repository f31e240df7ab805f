#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "collab/simulated/breakages.h"
#include "collab/simulated/simulated_session.h"

namespace tandem {

/// Who answers for every body, and in whose hand it is (docs/decisions/0016), judged from outside.
///
/// At each peer, always: its knowledge of who answers for a body only ever goes to a greater claim,
/// of the later epoch or, of one epoch, of the lower peer; to a lesser one where the claimant of the
/// greater is gone or does not go by it, and, beside a hostile member, at any time.
///
/// A peer that has stood still for more than 0.5 s says of no body where it is for the next 0.3 s.
///
/// Among the peers of a part of the network that is *settled*: every one of them has heard every
/// other, uncut and running, for two ways and 0.3 s, and nobody else can hear or be heard by any.
/// - A body that only one may hold is in at most one hand.
/// - Of such a body, and of where a parked one stands, nobody says anything under a smaller claim
///   than another of them has before.
/// - All name the same peer, at most two ways and 0.3 s after the newest claim was made.
/// - That peer is one of them, at most a lease, a beat, 0.3 s and two ways after the one before
///   went; 1.5 s more for each of them that came later than it went, for who never heard of it does
///   not take over, and the next in line waits for that long.
/// A way: the longest that control traffic has lately needed anywhere, re-sends included.
class AuthorityChecker {
 public:
  AuthorityChecker(const WorldModel& model, Breakages& breakages);

  /// What it answers for, nobody else needs to.
  void SetHostile(PeerId peer) { hostile_ = peer; }
  /// After every frame.
  void Look(SimulatedSession& session);
  void OnState(PeerId from, const ObjectState& state);
  /// When all is quiet, since `quiet_ns`: every body is answered for by a peer that is here, whoever
  /// is asked; and by the same one, but for what may have begun then and not be settled yet. Peers
  /// that claim a body above one another for ever make new claims for ever.
  void LookAtEnd(SimulatedSession& session, std::int64_t quiet_ns);

 private:
  struct Known {  // claim, as a peer knows it or says it
    std::uint32_t epoch = 0;
    PeerId peer = 0;
    bool operator<(const Known& b) const {
      return epoch != b.epoch ? epoch < b.epoch : peer > b.peer;
    }
    bool operator==(const Known&) const = default;
  };
  struct Said {
    PeerId from = 0;
    std::size_t body = 0;
    Known claim;
  };
  struct Part {  // a settled part of the network
    std::vector<std::size_t> members;
    std::vector<std::int64_t> agreed_ns;  // per body: when last all was well, or the newest claim
    std::vector<std::int64_t> one_ns;     // per body: when last all named the same peer
    std::vector<Known> greatest;          // per body
    std::vector<Known> said;              // per body, on the wire, since it is settled
    std::vector<std::int64_t> said_ns;    // since when
  };

  void LookAtClaims(SimulatedSession& session);
  bool MayGoBack(SimulatedSession& session, std::size_t member, std::size_t body);
  std::vector<std::vector<std::size_t>> SettledParts(const SimulatedSession& session);
  void LookAtPart(SimulatedSession& session, Part& part);
  void LookAtSaid();
  Part* PartOf(PeerId peer);
  /// How many of a part came since that peer went.
  std::int64_t CameSince(const Part& part, PeerId gone) const;
  static Known ClaimAt(SimulatedSession& session, std::size_t member, std::size_t body);

  const WorldModel* model_;
  PeerId hostile_ = 0;  // 0: there is none
  Breakages* breakages_;
  std::int64_t now_ns_ = 0;
  std::int64_t way_ns_ = 0;
  std::vector<PeerId> ids_;                // by member
  std::vector<std::int64_t> came_ns_;      // by member
  std::vector<std::int64_t> gone_ns_;      // by member: since when it is not here; 0: it is
  std::vector<std::int64_t> awake_ns_;     // by member: since when it runs
  std::vector<std::int64_t> halted_ns_;    // by member: since when it stands; 0: it runs
  std::vector<std::int64_t> silent_ns_;    // by member: until when it may say nothing
  std::vector<std::vector<Known>> known_;  // [member][body], a frame ago
  std::vector<Part> parts_;
  std::vector<Said> said_;  // in this frame
};

}  // namespace tandem
