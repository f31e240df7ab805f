#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collab/session/drop_counts.h"
#include "collab/session/membership.h"
#include "collab/session/peer_map.h"
#include "engine/world/world_model.h"

namespace tandem {

/// News about a body, for the person at the device.
struct Notification {
  enum class Kind : std::uint8_t {
    kInHand,        // it is in our hand now
    kAsking,        // `peer` answers for it and has been asked
    kRefused,       // `peer` holds it
    kAsked,         // `peer` asks for it, but our hand holds it
    kNoAnswer,      // nobody answered for 5 s
    kLetGo,         // we released it
    kGiven,         // we handed it to `peer`
    kTaken,         // `peer` has it by the greater claim
    kInherited,     // its last authority is gone: this peer answers for it
    kForceStopped,  // its force on our hand was not a number: the hand feels nothing from now on
    kApart,         // something fixed is between our instance and that of `peer`
    kNotApart,      // nothing fixed is between the instances that the user wants to join
    kComingBack,    // our instance goes to that of `peer`; our hand lets go meanwhile
    kNoWayBack,     // no way to the instance of `peer` is known
    kTogether,      // nothing is between our instance and that of `peer` any more
    kCrowded,       // it has more contacts than there is room for; said once
    kUncoupled,     // `peer` holds it too, beyond kMaxLinks others: neither end pulls
    kStopped        // the user asked for it during an emergency stop
  };
  Kind kind = Kind::kInHand;
  ObjectId object = kNoObject;
  PeerId peer = 0;
};

/// Decides which peer answers for every moving body, and which body the own hand holds (paper §6.1:
/// type-1 and type-2). A state machine of the haptic thread, fed with the time, the other peers'
/// claims and events, and the user's wishes. It reads no clock and allocates nothing after
/// construction.
///
/// Every body has one authority: the peer with the greatest claim. A later epoch is greater, then a
/// lower id; without any claim the lowest active peer is the authority. The authority alone says
/// where the body is. Each holder of a shared body says where its own instance is. To take a body a
/// peer asks the authority, which grants it (epoch + 1) and gives it up in that same frame. The
/// authority of a free body simulates it, and leaves it the same way to the peer whose hand pushes
/// it. When an authority goes, the lowest remaining peer takes its bodies; of a shared body in
/// hands, the lowest holder. A peer whose own clock jumped listens before it acts as an authority
/// again. So peers that hear one another have one authority for each body. Parts of a torn network
/// have one each, until they meet and the greater claim counts. docs/decisions/0016-authority.md
///
/// Not every peer keeps to this. So a claim on another's body counts only if the owner is gone or
/// says itself that it has given the body away. Of two peers that both got a body while they were
/// apart, the one that most peers name keeps it. Grants and releases count from the authority
/// alone, or from the next peer in line where it is gone; refusals from the peer that was asked.
/// Epochs rise no faster than grabbing allows. A misled peer goes back.
/// docs/decisions/0036-who-may-say-what.md
class Ownership {
 public:
  /// `settle_ns`: time after the first frame in which this peer takes no body by itself, for others
  /// may have been here long. `own_only`: the hand takes no shared body, for the other peers have
  /// other force parameters. `drops`: the table that counts refused samples; null: none.
  Ownership(PeerId self, const WorldModel& model, std::int64_t settle_ns = 0, bool own_only = false,
            DropTable* drops = nullptr);

  /// Begins a frame, ahead of all that is heard in it, so that a peer that was stopped notices the
  /// pause. Tick() calls it if nothing else has.
  void Begin(std::int64_t now_ns) noexcept;
  /// Judges all that several peers said at once; called after the last change of a frame.
  void Settle() noexcept;
  void OnMembership(const MembershipChange& change) noexcept;
  void OnEvent(const Event& event) noexcept;
  /// Keeps the pose of a parked body, and forgets it when the body moves. For accepted samples
  /// only.
  void OnState(const ObjectState& state) noexcept;
  /// Returns whether the sender of a sample may send it about that body.
  bool Accepts(const ObjectState& state) const noexcept;

  /// The user's wishes. Ask() first releases the body in hand. A body that was asked for and is not
  /// wanted any more is not taken, though its grant may be on its way.
  void Ask(ObjectId object) noexcept;
  void Release() noexcept;
  /// Emergency stop: releases the body, and takes none in hand until Resume().
  void Stop() noexcept;
  void Resume() noexcept { stopped_ = false; }
  bool stopped() const noexcept { return stopped_; }
  void Give(PeerId to) noexcept;
  /// Asks the other holders of the body in our hand to bring the instances together.
  void RequestReunion() noexcept;

  /// Takes the pose of each moving body as simulated here; first in each frame.
  void SetPose(std::size_t body, const Pose& X_WB) noexcept { bodies_[body].X_WB = X_WB; }
  /// Notes that the body in our hand pushed this free one in the last frame. Tells the authority,
  /// which may leave the body to us. After Begin().
  void NoteTouch(std::size_t body) noexcept;
  /// Handles time-outs, succession and repeated requests. Events to send go to `out`; those that
  /// find no room there wait for the next frame.
  void Tick(std::int64_t now_ns, std::span<Event> out, std::size_t& count) noexcept;
  /// Hands all bodies that this peer answers for to the remaining peers.
  void Leave() noexcept;

  PeerId authority(std::size_t body) const noexcept;
  std::uint32_t epoch(std::size_t body) const noexcept { return bodies_[body].claim.epoch; }
  /// The epoch of this peer's claim on a body that it holds or answers for, and of its samples.
  std::uint32_t own_epoch(std::size_t body) const noexcept {
    return bodies_[body].claim.peer == self_ ? bodies_[body].claim.epoch : hold_epoch_;
  }
  /// The moving body in our hand; -1: none.
  int held() const noexcept { return held_; }
  /// The moving body that we have asked for; -1: none.
  int wanted() const noexcept { return wanted_; }
  bool HeldBy(std::size_t body, PeerId peer) const noexcept;
  /// Writes the other peers that hold a body; returns how many.
  std::size_t Holders(std::size_t body, std::array<PeerId, kMaxPeers>& out) const noexcept;
  /// Returns whether this peer says where the body stands, and simulates it if it is free.
  bool Parks(std::size_t body) const noexcept;
  /// The pose at which another peer put the body down or handed it to us, if no peer has moved it
  /// since; null: the body stands where it is here.
  const Pose* ParkedAt(std::size_t body) const noexcept;
  /// Returns whether this peer listens after a pause. Then it says nothing of bodies held and
  /// parked.
  bool listening() const noexcept { return now_ns_ < listen_until_ns_; }
  /// Returns whether this peer has just joined and may not have heard all others.
  bool is_new() const noexcept { return now_ns_ - first_ns_ < kNew; }

  /// Writes this peer's claims, for peer_info; returns how many.
  std::uint32_t Claims(std::array<Claim, kMaxClaims>& out) const noexcept;
  /// Writes the believed authorities of the bodies that others answer for; returns how many.
  std::uint32_t Beliefs(std::array<Belief, kMaxClaims>& out) const noexcept;
  bool TakeNotifications(Notification& notification) noexcept;

 private:
  static constexpr std::int64_t kNew = 5'000'000'000;  // ns; exceeds the longest delay of messages
  static constexpr std::int64_t kAllTold = 5'000'000'000;  // ns; likewise
  static constexpr std::int64_t kAskAgain = 250'000'000;   // ns; from one request to its repetition
  static constexpr std::int64_t kEpoch =
      100'000'000;  // ns; each peer may raise an epoch by one in it
  static constexpr std::int64_t kLostWait = 300'000'000;  // ns, after the lease of a lost authority
  static constexpr std::int64_t kMostEpochs = 1000;       // at first
  // greatest first epoch of a body without a known authority: hours of grabs, far from kLastEpoch
  static constexpr std::uint32_t kMostAtFirst = 100'000;
  struct BodyClaim {
    std::uint32_t epoch = 0;
    PeerId peer = 0;  // 0: nobody has claimed it yet
  };
  struct FormerOwner {
    PeerId peer = 0;
    std::int64_t until_ns = 0;
  };
  struct Body {
    std::size_t index = 0;  // into bodies_
    ObjectId object = 0;
    bool shared = false;
    bool free = false;
    BodyClaim claim;
    std::uint32_t began_epoch = 0;  // epoch under which the claimant got it
    std::int64_t first_epoch = 0;   // epoch of the first claim believed here
    std::uint32_t last_epoch = 0;   // last epoch under which this peer had it
    std::int64_t claimed_ns = 0;    // when the claimant got it, as known here
    bool disputed = false;          // another peer claims it too, and is not believed (yet)
    std::int64_t disputed_ns = 0;   // start of the dispute
    bool undecided = false;         // it is ours, and the votes against us are older than our claim
    std::int64_t tied_ns = 0;       // since when as many name a rival as name us
    std::int64_t ahead_ns = 0;      // since when a rival is ahead of the believed peer
    std::int64_t outdone_ns = 0;    // since when a lesser claim is better than the believed one
    std::int64_t tied_with_named_ns = 0;  // since when others name a lower peer under our epoch
    bool even = false;           // as many name a lower peer that was never away as name us
    int contests = 0;            // times we have claimed it above that peer since
    bool unsure = false;         // first belief about the body, with no earlier owner known
    std::int64_t unsure_ns = 0;  // when that belief began
    /// Peers in whose absence the body came to the believed peer, the first one first; 0: none.
    std::array<PeerId, 4> in_absence_of{};
    std::int64_t reasserted_ns = 0;       // when we last claimed it anew
    std::int64_t risen_ns = 0;            // when others' words last raised our epoch
    std::array<FormerOwner, 3> before{};  // last owners, the latest first
    Pose X_WB;                            // pose here
    Pose parked;                          // pose told by its authority
    bool reported = false;
    std::int64_t orphaned_ns = 0;  // since when its claimant does not answer for it; 0: it does
    bool forsaken = false;     // the claimant's run that had it is over, and another run is here
    bool by_another = false;   // the claim is believed on another peer's word
    std::int64_t less_ns = 0;  // since when that claimant itself claims less
    bool by_word = false;      // it is ours by another's word, and the grant is on its way
    bool handed = false;       // we handed it to the claimant, by this event:
    EventKind handed_by = EventKind::kGrant;
    std::int64_t sent_ns = 0;  // when that event was last sent
    bool passed_on = false;    // its grant was repeated since the loss, for peers before us in line
    std::int64_t withdrawn_ns = 0;   // when our request for it was withdrawn; 0: never
    std::int64_t touched_ns = 0;     // when the body in our hand last pushed it; 0: never
    std::int64_t touch_sent_ns = 0;  // when its authority was last told of that
  };
  struct Member {
    PeerId peer = 0;
    bool present = false;
    bool left = false;
    bool anew = false;  // an earlier run of it was here, or it had left
    std::array<std::optional<Claim>, kMaxClaims> claims;    // by body
    std::array<std::optional<Belief>, kMaxClaims> beliefs;  // by body
    int held_before = -1;  // body that it held when our hand took it, and has held since; -1: none
    std::int64_t since_ns = 0;  // since when it has been present, or gone, without a break
    std::int64_t known_ns = 0;  // when it was first heard of: epochs are earned from then on
    std::int64_t epochs = 0;    // epochs beyond MostEpoch() that its claims and grants have used up
    std::int64_t answered_ns = 0;        // until when earlier answers use up its share
    Claim refused{kNoObject, 0, false};  // last refused claim that was counted
  };

  /// A peer that asked for the body in our hand, as last told to the user.
  struct Requester {
    PeerId peer = 0;
    ObjectId object = kNoObject;
    std::int64_t reported_ns = 0;
  };

  static bool Greater(std::uint32_t epoch, PeerId peer, const Body& than) noexcept;
  static std::uint32_t Next(std::uint32_t epoch) noexcept {
    return epoch < kLastEpoch ? epoch + 1 : epoch;
  }
  void Refuse(PeerId peer, Drop reason) noexcept {
    if (drops_ != nullptr) drops_->Count(peer, reason);
  }
  int BodyOf(ObjectId object) const noexcept;
  /// Returns the peer's place among the members, a new one if need be: a free one, else the place
  /// of a peer that is gone. Null: more peers are here than a session may have.
  Member* PlaceFor(PeerId peer) noexcept;
  static const Claim* ClaimOf(const Member& member, std::size_t body) noexcept;
  /// Marks the bodies of a member's earlier run as given away, for another run of it is here.
  void BeginAnew(Member& member) noexcept;
  /// Keeps a member's claims and beliefs, by body.
  void Keep(const MembershipChange& change, Member& member) const noexcept;
  bool IsHere(PeerId peer) const noexcept;
  int CountHere() const noexcept;
  /// The greatest epoch of a body that is believed on anybody's word.
  std::int64_t MostEpoch(const Body& body) const noexcept;
  /// Epochs earned since then, as the peer that joined last counts them.
  std::int64_t EpochsSince(std::int64_t since_ns) const noexcept;
  /// Counts the members here that name `peer` under an epoch not far below `epoch`.
  int VotesNear(const Body& body, const Member& peer, std::uint32_t epoch) const noexcept;
  /// Returns whether the word of `by` may raise a body's epoch to `epoch` now.
  bool Affords(const Member& by, const Body& body, std::uint32_t epoch) const noexcept;
  /// Returns whether the claimant holds a shared body beside its authority.
  static bool HoldsBeside(const Body& body, const Claim& claim) noexcept;
  /// Notes a claim: believes it where it is the greater one and undisputed.
  void NoteClaim(std::size_t body, const Claim& claim, Member& by) noexcept;
  /// Makes `claim` the believed one, on the word of `by`.
  void Believe(std::size_t body, const BodyClaim& claim, Member& by, bool in_its_hand) noexcept;
  static const Belief* BeliefOf(const Member& member, std::size_t body) noexcept;
  /// The peer that a member takes for the authority of a body; 0: it knows of none.
  static PeerId NamedBy(const Member& member, std::size_t body) noexcept;
  PeerId VoteOf(const Member& member, std::size_t body) const noexcept;
  /// Returns whether a member names `named` under an epoch from before its claimant had the body.
  bool IsStale(const Member& member, const Body& body, PeerId named) const noexcept;
  /// Returns whether the belief is certain: no first belief, not due to an absence, and not new
  /// here.
  bool IsSure(const Body& body) const noexcept;
  bool HadItRecently(const Body& body, PeerId peer) const noexcept;
  /// Notes the present owner as a former one. `by_its_word`: that peer has given the body away, and
  /// is not just missing.
  void NoteBefore(Body& body, bool by_its_word) noexcept;
  /// Counts the other members here that take that peer for the authority.
  int VotesFor(const Body& body, PeerId peer) const noexcept;
  /// Returns whether a newcomer, whose name is no vote yet, names that peer.
  bool IsHearsay(const Body& body, PeerId peer) const noexcept;
  /// Counts those votes that name the peer under an epoch from before its claimant had the body.
  int StaleFor(const Body& body, PeerId peer) const noexcept;
  /// Counts the other members here that name the believed peer, or a recent owner, and not `rival`.
  int VotesAgainst(const Body& body, PeerId rival) const noexcept;
  /// Another peer than the believed one that claims the body.
  struct Rival {
    Member* member = nullptr;  // null: there is none
    const Claim* claim = nullptr;
    int votes = 0;
  };
  /// Returns the rival with the most votes among those that claim more, or less, than the believed
  /// peer.
  Rival RivalOf(std::size_t body, bool claims_more) noexcept;
  PeerId GoneTo(const Body& body, bool by_any_word = false) const noexcept;
  /// Returns whether the authority says that the body went to that peer, directly or through
  /// others.
  bool SaysGoneTo(const Body& body, PeerId peer) const noexcept;
  /// Forgets `from` and the peers that were missed after it.
  static void ForgetAbsent(Body& body, PeerId from) noexcept;
  void LookForAbsent(Body& body) noexcept;
  /// Returns whether a peer in whose absence the body came to the believed one is back and names
  /// `peer`.
  bool SaidByReturned(const Body& body, PeerId peer) const noexcept;
  bool KeepsOurs(std::size_t body, const Rival& rival) noexcept;
  bool IsAhead(const Body& body, const Rival& rival) const noexcept;
  /// Returns whether another peer holds the body that our hand is about to take, and has more votes
  /// than this peer; as many where this peer is unsure.
  bool IsInAnothersHand(std::size_t body) const noexcept;
  bool LeavesFor(std::size_t body, const Rival& rival) noexcept;
  /// Returns whether a greater claim has misled this peer, so that it goes back to the lesser one.
  bool GoesBackTo(std::size_t body, const Rival& rival) noexcept;
  void Follow(std::size_t body, const Rival& rival) noexcept;
  void FollowItsWord(std::size_t body) noexcept;
  /// Goes back to the claimant's own lesser claim, where another peer's word raised it and it does
  /// not.
  void GoBackToItsOwn(std::size_t body) noexcept;
  void RiseTo(Body& body, std::uint32_t epoch) noexcept;
  void RiseToNamed(std::size_t body) noexcept;
  void JudgeFirst(std::size_t body) noexcept;
  void Judge(std::size_t body) noexcept;
  void CountOnce(Member& member, const Claim& claim, Drop reason) noexcept;
  /// Claims a kept body anew, above the claims that others may believe; returns whether it did.
  bool Reassert(std::size_t body, std::uint32_t above) noexcept;
  /// The lowest other peer here that, if `holding_body` >= 0, holds that body; 0: none.
  PeerId LowestOther(int holding_body) const noexcept;
  bool HeldByOther(std::size_t body) const noexcept;
  void TakeInHand(std::size_t body) noexcept;
  /// Makes `to` the authority, from this frame on.
  void HandOver(std::size_t body, EventKind kind, PeerId to) noexcept;
  void QueueEvent(EventKind kind, std::size_t body, std::uint32_t epoch, PeerId to) noexcept;
  void Notify(Notification::Kind kind, std::size_t body, PeerId peer) noexcept;
  bool MayAnswer(PeerId from) noexcept;
  void OnAsk(std::size_t body, PeerId from) noexcept;
  /// Leaves a free body to the peer whose body pushes it, unless ours pushes it.
  void OnTouch(std::size_t body, PeerId from) noexcept;
  /// Tells the user that a peer asks for the body in our hand: for each peer once in a while,
  /// however often it asks.
  void NotifyRequested(std::size_t body, PeerId from) noexcept;
  void OnGrant(std::size_t body, const Event& event) noexcept;
  /// Puts a granted body where the event says, and takes it in hand if our hand is to have it.
  void TakeGiven(std::size_t body, const Event& event) noexcept;
  /// Goes on towards the body that the hand wants.
  void RepeatRequests() noexcept;
  /// Takes over bodies that have lost their authority, where it is this peer's turn.
  void Succeed() noexcept;
  /// Takes over a body that another peer had, when it is our turn.
  void SucceedTo(std::size_t b) noexcept;
  /// Counts the peers that are to take the body over before us.
  std::int64_t PeersBefore(std::size_t b) const noexcept;

  PeerId self_;
  std::int64_t settle_ns_;
  bool own_only_;
  DropTable* drops_;
  std::vector<Body> bodies_;
  PeerMap<Member, kMaxPeers> members_;
  int held_ = -1;
  std::uint32_t hold_epoch_ = 0;  // epoch of our claim on a shared body of another authority
  int wanted_ = -1;
  bool stopped_ = false;
  std::int64_t wanted_since_ns_ = 0;
  std::int64_t asked_ns_ = 0;       // when last asked; 0: not yet
  PeerId requested_ = 0;            // peer asked
  std::int64_t touch_sent_ns_ = 0;  // when last, about any body
  PeerMap<Requester, kMaxPeers> requesters_;
  std::int64_t now_ns_ = 0;  // time of the last frame; 0: none yet
  std::int64_t listen_until_ns_ = 0;
  std::int64_t paused_ns_ = 0;       // end of our last pause; 0: there was none
  std::int64_t first_ns_ = 0;        // first frame
  std::int64_t last_joined_ns_ = 0;  // when the newest unknown peer joined
  std::int64_t own_epochs_ = 0;      // epochs by which disputes have raised our own claims
  std::uint32_t event_seq_ = 0;
  std::vector<Event> to_send_;  // ring of waiting events
  std::size_t send_first_ = 0;
  std::size_t send_count_ = 0;
  std::array<Notification, 16> notifications_{};
  std::size_t news_count_ = 0;
};

}  // namespace tandem
