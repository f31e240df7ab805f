#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collab/drop_counts.h"
#include "collab/membership.h"
#include "engine/world/world_model.h"

namespace tandem {

/// What became of a body, for the person at the device.
struct HoldingNews {
  enum class Kind : std::uint8_t {
    kInHand,        // it is in our hand now
    kAsking,        // `peer` answers for it and has been asked
    kRefused,       // `peer` holds it
    kAsked,         // `peer` asks for it, which is in our hand
    kNoAnswer,      // nobody answered for 5 s
    kLetGo,         // we released it
    kGiven,         // we handed it to `peer`
    kTaken,         // `peer` has it by the greater claim
    kInherited,     // its last authority is gone: we answer for it
    kForceStopped,  // what it puts on our hand is no number: the hand feels nothing from now on
    kApart,         // something fixed is between our instance and that of `peer`
    kNotApart,      // nothing is, and we asked to be brought together
    kComingBack,    // our instance goes to that of `peer`, our hand is let go of meanwhile
    kNoWayBack,     // no way to it is known
    kTogether,      // nothing is between them any more
    kCrowded,       // it has more contacts than there is room for; said once
    kUncoupled,     // `peer` holds it too, as more than kMaxLinks others do: neither pulls
    kStopped        // it was asked for during an emergency stop
  };
  Kind kind = Kind::kInHand;
  ObjectId object = kNoObject;
  PeerId peer = 0;
};

/// Who answers for every moving body, and what our own hand holds (paper §6.1: type-1 and type-2).
/// A pure state machine of the haptic thread, fed with the time, the others' claims and events, and
/// the user's wishes; it reads no clock and allocates nothing after construction.
///
/// Every body has one authority, the peer of the greatest claim: of the later epoch, then of the
/// lower id; without any claim, the lowest active peer. The authority alone says where the body is,
/// but for a shared one in several hands, of which every holder says its own instance. To take a
/// body one asks its authority, who grants it (epoch + 1) and gives it up in that same frame. A
/// free body, which its authority simulates, is left in the same way to whose hand pushes it. When
/// an authority goes, the lowest peer left takes its bodies (of a shared one in hands, the lowest
/// holder). A peer whose own clock jumped listens before it acts as an authority again. Among peers
/// that hear one another there is so one authority; between parts of a torn network one in each,
/// until they meet and the greater claim counts. docs/decisions/0016-authority.md
///
/// Not everybody keeps to this. So a claim on what another has counts only if that one is gone or
/// says itself that it has given it away. Two who both have it, as they were apart, go by whom most
/// of those here name. Grants and releases count from the authority alone, or in turn where it is
/// gone, refusals from whom we asked, and epochs rise no faster than anybody can grab. Who was
/// misled goes back. docs/decisions/0036-who-may-say-what.md
class Holdings {
 public:
  /// Nobody takes a body by itself for `settle_ns` after the first frame: others may have been here
  /// long.
  /// `own_only`: takes no shared body in hand, for its force parameters are not the others'.
  /// `drops`: where what is refused is counted; null: nowhere.
  Holdings(PeerId self, const WorldModel& model, std::int64_t settle_ns = 0, bool own_only = false,
           DropTable* drops = nullptr);

  /// A frame begins: before what is heard in it, so that one who was stopped knows that it was.
  /// Tick() does it where nobody else has.
  void Begin(std::int64_t now_ns) noexcept;
  /// What several tell at once is judged together: Settle() after the last of a frame.
  void Settle() noexcept;
  void OnMembership(const MembershipChange& change) noexcept;
  void OnEvent(const Event& event) noexcept;
  /// Keeps the pose of a parked body; one that moves again has none. Of samples that are accepted.
  void OnState(const ObjectState& state) noexcept;
  /// Whether a sample is one that the peer who sent it may send of that body.
  bool Accepts(const ObjectState& state) const noexcept;

  /// The user's wishes. What the hand holds already is released first. What it has asked for and
  /// wants no more it does not take, though its grant may be on its way.
  void Ask(ObjectId object) noexcept;
  void Release() noexcept;
  /// Emergency stop: releases, and takes nothing in hand until Resume().
  void Stop() noexcept;
  void Resume() noexcept { stopped_ = false; }
  void Give(PeerId to) noexcept;
  /// Asks the others who hold the body in our hand to be brought together with us.
  void Heal() noexcept;

  /// Where each moving body is, as simulated here; first in each frame.
  void SeeAt(std::size_t body, const Pose& X_WB) noexcept { bodies_[body].X_WB = X_WB; }
  /// The body in our hand pushed this free one in the last frame. Its authority is told so, and may
  /// leave it to us. After Begin().
  void Touch(std::size_t body) noexcept;
  /// Time-outs, succession, asking again. Events to send go to `out`, those that find no room there
  /// wait for the next frame.
  void Tick(std::int64_t now_ns, std::span<Event> out, std::size_t& count) noexcept;
  /// Hands all that we answer for to those who stay.
  void Leave() noexcept;

  PeerId authority(std::size_t body) const noexcept;
  std::uint32_t epoch(std::size_t body) const noexcept { return bodies_[body].claim.epoch; }
  /// The epoch of our own claim on what we hold or answer for, and of our samples of it.
  std::uint32_t own_epoch(std::size_t body) const noexcept {
    return bodies_[body].claim.peer == self_ ? bodies_[body].claim.epoch : hold_epoch_;
  }
  /// The moving body in our hand, or -1.
  int held() const noexcept { return held_; }
  /// The moving body that we have asked for, or -1.
  int wanted() const noexcept { return wanted_; }
  bool HeldBy(std::size_t body, PeerId peer) const noexcept;
  /// The other peers that hold a body; how many.
  std::size_t Holders(std::size_t body, std::array<PeerId, kMaxPeers>& out) const noexcept;
  /// Tells whether this peer says where the body stands, and simulates it if it is free.
  bool Parks(std::size_t body) const noexcept;
  /// Where another peer has put the body down or handed it to us, and nobody has moved it since;
  /// null: it stands where it is here.
  const Pose* ParkedAt(std::size_t body) const noexcept;
  /// Whether what we hold and park may be said: not while we listen after a pause.
  bool listening() const noexcept { return now_ns_ < listen_until_ns_; }
  /// Whether we came a moment ago, and have perhaps not heard everybody.
  bool is_new() const noexcept { return now_ns_ - first_ns_ < kNew; }

  /// What we claim, for peer_info; the number of claims.
  std::uint32_t Claims(std::array<Claim, kMaxClaims>& out) const noexcept;
  /// Whom we take for the authorities of what others answer for; how many.
  std::uint32_t Beliefs(std::array<Belief, kMaxClaims>& out) const noexcept;
  bool TakeNews(HoldingNews& news) noexcept;

 private:
  static constexpr std::int64_t kNew = 5'000'000'000;  // ns, over the longest ways
  static constexpr std::int64_t kEpoch =
      100'000'000;  // ns, in which each peer may raise one by one
  static constexpr std::int64_t kLostWait = 300'000'000;  // ns, after the lease of a lost authority
  static constexpr std::int64_t kMostEpochs = 1000;       // at first
  // of a body that nobody is known to answer for: hours of grabs, and far from the last
  static constexpr std::uint32_t kMostAtFirst = 100'000;
  struct BodyClaim {
    std::uint32_t epoch = 0;
    PeerId peer = 0;  // 0: nobody has claimed it yet
  };
  struct Before {
    PeerId peer = 0;
    std::int64_t until_ns = 0;
  };
  struct Body {
    std::size_t index = 0;  // in bodies_
    ObjectId object = 0;
    bool shared = false;
    bool free = false;
    BodyClaim claim;
    std::uint32_t began_epoch = 0;        // under which its claimant came to have it
    std::int64_t first_epoch = 0;         // of the first claim that we believed
    std::uint32_t last_epoch = 0;         // under which we had it
    std::int64_t claimed_ns = 0;          // since when its claimant has it, as known here
    bool disputed = false;                // somebody claims it too, and is not believed (yet)
    std::int64_t disputed_ns = 0;         // since when
    bool undecided = false;               // ours, and votes against that are older than our claim
    std::int64_t tied_ns = 0;             // since when as many name another as name us
    std::int64_t ahead_ns = 0;            // since when another is ahead of whom we believe
    std::int64_t outdone_ns = 0;          // since when one is that claims less
    std::int64_t tied_with_named_ns = 0;  // since when others name a lower one under our epoch
    bool even = false;                    // as many name a lower one that was never away as name us
    int contests = 0;                     // how often we have claimed it above that one since
    bool unsure = false;                  // we came anew when we believed it, and asked nobody
    std::int64_t unsure_ns = 0;           // since when
    /// Those in whose absence it came to the one that we believe, the first first; 0: no more.
    std::array<PeerId, 4> in_absence_of{};
    std::int64_t reasserted_ns = 0;  // when we last claimed it anew
    std::int64_t risen_ns = 0;       // when others' words last raised our epoch
    std::array<Before, 3> before{};  // who had it last, the latest first
    Pose X_WB;                       // here
    Pose parked;                     // as told by its authority
    bool told = false;
    std::int64_t orphaned_ns = 0;  // since when its claimant does not answer for it; 0: it does
    bool forsaken = false;         // its claimant's run that had it is over, and another is here
    bool by_another = false;       // what its claimant claims we have from another
    std::int64_t less_ns = 0;      // since when that one claims less itself
    bool by_word = false;          // it is ours by another's word, and the grant is on its way
    bool handed = false;           // by us, to the claimant, in that way:
    EventKind handed_by = EventKind::kGrant;
    std::int64_t said_ns = 0;  // when last
    bool passed_on = false;    // since it was lost: who is before us in line may not know the claim
    std::int64_t withdrawn_ns = 0;   // when we ceased to want what we had asked for; 0: never
    std::int64_t touched_ns = 0;     // when what we hold last pushed it; 0: never
    std::int64_t touch_said_ns = 0;  // when its authority was last told so
  };
  struct Member {
    PeerId peer = 0;  // 0: a free place
    bool present = false;
    bool left = false;
    bool anew = false;  // another run of it was here before this one, or it had left
    std::array<std::optional<Claim>, kMaxClaims> claims;    // by body
    std::array<std::optional<Belief>, kMaxClaims> beliefs;  // by body
    int held_before = -1;  // what it said that it held as we took it in hand, and says so since
    std::int64_t since_ns = 0;                              // present without a break
    std::int64_t known_ns = 0;  // since it was first heard of: epochs are earned
    std::int64_t epochs = 0;    // that its claims and grants have been believed to go beyond
    std::int64_t answered_ns = 0;  // until when our answers to it have used up their share
    Claim refused{kNoObject, 0, false};  // counted last
  };

  /// A peer that asked for what our hand holds, as last told to the user.
  struct Asker {
    PeerId peer = 0;  // 0: a free place
    ObjectId object = kNoObject;
    std::int64_t told_ns = 0;
  };

  static bool Greater(std::uint32_t epoch, PeerId peer, const Body& than) noexcept;
  static std::uint32_t Next(std::uint32_t epoch) noexcept {
    return epoch < kLastEpoch ? epoch + 1 : epoch;
  }
  void Refuse(PeerId peer, Drop reason) noexcept {
    if (drops_ != nullptr) drops_->Count(peer, reason);
  }
  int BodyOf(ObjectId object) const noexcept;
  const Member* Find(PeerId peer) const noexcept;
  Member* PlaceFor(PeerId peer) noexcept;
  static const Claim* ClaimOf(const Member& member, std::size_t body) noexcept;
  /// Another run of it is here, which has nothing of what the one before had.
  void BeginAnew(Member& member) noexcept;
  /// Keeps what a member claims and whom it names, by body.
  void Keep(const MembershipChange& change, Member& member) const noexcept;
  bool IsHere(PeerId peer) const noexcept;
  int CountHere() const noexcept;
  /// Up to which what anybody says of a body may be believed.
  std::int64_t MostEpoch(const Body& body) const noexcept;
  /// What may be earned in the time since then, as whoever came last knows it.
  std::int64_t EpochsSince(std::int64_t since_ns) const noexcept;
  /// How many of those here name that peer under an epoch that is not far below that one.
  int VotesNear(const Body& body, const Member& peer, std::uint32_t epoch) const noexcept;
  /// Whether what `by` says may bring a body to that epoch now.
  bool Affords(const Member& by, const Body& body, std::uint32_t epoch) const noexcept;
  /// Tells whether the claimant holds a shared body beside the one that answers for it.
  static bool HoldsBeside(const Body& body, const Claim& claim) noexcept;
  /// Takes note of a claim where it is the greater one and nobody disputes it.
  void Note(std::size_t body, const Claim& claim, Member& by) noexcept;
  /// Makes it the claim that counts, on the word of `by`.
  void Believe(std::size_t body, const BodyClaim& claim, Member& by, bool in_its_hand) noexcept;
  static const Belief* BeliefOf(const Member& member, std::size_t body) noexcept;
  /// Whom a member takes for the authority of a body; 0: it knows of none.
  static PeerId NamedBy(const Member& member, std::size_t body) noexcept;
  PeerId VoteOf(const Member& member, std::size_t body) const noexcept;
  /// Returns whether a member names `named` under an epoch from before its claimant had the body.
  bool IsStale(const Member& member, const Body& body, PeerId named) const noexcept;
  /// Returns whether we believe what we do neither as a newcomer nor because somebody was gone.
  bool IsSure(const Body& body) const noexcept;
  bool HadItLately(const Body& body, PeerId peer) const noexcept;
  /// Of who has it until now; `by_its_word`: that one has given it away, and is not just missed.
  void NoteBefore(Body& body, bool by_its_word) noexcept;
  /// How many of the others who are here take that peer for the authority.
  int VotesFor(const Body& body, PeerId peer) const noexcept;
  /// Returns whether a newcomer, whose name is no vote yet, names that peer.
  bool IsHearsay(const Body& body, PeerId peer) const noexcept;
  /// Returns how many of them do so under an epoch from before its claimant had the body.
  int StaleFor(const Body& body, PeerId peer) const noexcept;
  /// And how many whom we do, or who had it a moment ago, and not `rival`.
  int VotesAgainst(const Body& body, PeerId rival) const noexcept;
  /// Another than whom we take for the authority claims the body.
  struct Rival {
    Member* member = nullptr;  // null: there is none
    const Claim* claim = nullptr;
    int votes = 0;
  };
  /// Of those who claim more, or less, than whom we take for the authority, the one that most name.
  Rival RivalOf(std::size_t body, bool claims_more) noexcept;
  PeerId GoneTo(const Body& body, bool by_any_word = false) const noexcept;
  /// Whether the authority, or whom it says that it has gave it to, is that peer.
  bool SaysGoneTo(const Body& body, PeerId peer) const noexcept;
  /// That one, and those who were missed after it.
  static void ForgetAbsent(Body& body, PeerId from) noexcept;
  void LookForAbsent(Body& body) noexcept;
  /// Whether one in whose absence we came to believe what we do is back and names that peer.
  bool SaidByReturned(const Body& body, PeerId peer) const noexcept;
  bool KeepsOurs(std::size_t body, const Rival& rival) noexcept;
  bool IsAhead(const Body& body, const Rival& rival) const noexcept;
  /// Returns whether another holds what we are about to take, and as many name it as name us.
  bool IsInAnothersHand(std::size_t body) const noexcept;
  bool LeavesFor(std::size_t body, const Rival& rival) noexcept;
  /// Whether a greater claim has misled us.
  bool GoesBackTo(std::size_t body, const Rival& rival) noexcept;
  void Follow(std::size_t body, const Rival& rival) noexcept;
  void FollowItsWord(std::size_t body) noexcept;
  /// Whom we believe of another's word claims less itself, and does not raise it.
  void GoBackToItsOwn(std::size_t body) noexcept;
  void RiseTo(Body& body, std::uint32_t epoch) noexcept;
  void RiseToNamed(std::size_t body) noexcept;
  void JudgeFirst(std::size_t body) noexcept;
  void Judge(std::size_t body) noexcept;
  void CountOnce(Member& member, const Claim& claim, Drop reason) noexcept;
  /// Claims what we keep anew, above the claims that others may believe; whether it did.
  bool Reassert(std::size_t body, std::uint32_t above) noexcept;
  /// The lowest present peer that is not us and, if asked, holds the body; 0: none.
  PeerId LowestOther(int holding_body) const noexcept;
  bool HeldByOther(std::size_t body) const noexcept;
  void TakeInHand(std::size_t body) noexcept;
  /// Makes `to` the authority, from this frame on.
  void HandOver(std::size_t body, EventKind kind, PeerId to) noexcept;
  void Say(EventKind kind, std::size_t body, std::uint32_t epoch, PeerId to) noexcept;
  void Tell(HoldingNews::Kind kind, std::size_t body, PeerId peer) noexcept;
  bool MayAnswer(PeerId from) noexcept;
  void OnAsk(std::size_t body, PeerId from) noexcept;
  /// Leaves a free body to whose part pushes it, unless ours does.
  void OnTouch(std::size_t body, PeerId from) noexcept;
  /// Tells the user who asks for what our hand holds: of each peer once in a while, however often
  /// it asks.
  void TellAsked(std::size_t body, PeerId from) noexcept;
  void OnGrant(std::size_t body, const Event& event) noexcept;
  /// What was granted stands where the event says, and comes into our hand if that is to have it.
  void TakeGiven(std::size_t body, const Event& event) noexcept;
  /// Goes on towards what the hand wants.
  void Pursue() noexcept;
  /// Takes over what has lost its authority, where it is our turn.
  void Succeed() noexcept;

  PeerId self_;
  std::int64_t settle_ns_;
  bool own_only_;
  DropTable* drops_;
  std::vector<Body> bodies_;
  std::array<Member, kMaxPeers> members_{};
  int held_ = -1;
  std::uint32_t hold_epoch_ = 0;  // of our claim on a shared body that another answers for
  int wanted_ = -1;
  bool stopped_ = false;
  std::int64_t wanted_since_ns_ = 0;
  std::int64_t asked_ns_ = 0;       // when last; 0: not yet
  PeerId asked_ = 0;                // whom
  std::int64_t touch_said_ns_ = 0;  // when last, of any body
  std::array<Asker, kMaxPeers> askers_{};
  std::int64_t now_ns_ = 0;  // of the last frame; 0: none yet
  std::int64_t listen_until_ns_ = 0;
  std::int64_t paused_ns_ = 0;       // when our last pause ended; 0: there was none
  std::int64_t first_ns_ = 0;        // first frame
  std::int64_t last_joined_ns_ = 0;  // when the last one came that we had not known
  std::int64_t own_epochs_ = 0;      // by which we have raised our own claims in disputes
  std::uint32_t event_seq_ = 0;
  std::vector<Event> to_send_;  // ring of events that wait
  std::size_t send_first_ = 0;
  std::size_t send_count_ = 0;
  std::array<HoldingNews, 16> news_{};
  std::size_t news_count_ = 0;
};

}  // namespace tandem
