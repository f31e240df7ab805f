#pragma once

#include "collab/simulated/checkers/authority_checker.h"
#include "collab/simulated/checkers/energy_checker.h"
#include "collab/simulated/checkers/hand_checker.h"
#include "collab/simulated/checkers/keep_checker.h"
#include "collab/simulated/checkers/motion_checker.h"
#include "collab/simulated/checkers/pull_checker.h"
#include "collab/simulated/checkers/rest_checker.h"
#include "collab/simulated/checkers/wire_checker.h"

namespace tandem {

/// Judges every session, whatever is cut, lost or killed. It looks from outside, in true time, at
/// the wire, the simulations and the hands. Each part has its own checker.
class SessionChecker : public WireWatch {
 public:
  /// Bounds for hands that are not scripted.
  struct Bounds {
    bool fast = false;                            // as for MotionChecker
    double short_loop = PullChecker::kShortLoop;  // s
    double kept = EnergyChecker::kMostKept;       // J
  };
  SessionChecker(const FaultSchedule& schedule, const WorldModel& model, PeerId viewer)
      : SessionChecker(schedule, model, viewer, Bounds()) {}
  SessionChecker(const FaultSchedule& schedule, const WorldModel& model, PeerId viewer,
                 const Bounds& bounds)
      : schedule_(&schedule),
        wire_(schedule, viewer, breakages_),
        authority_(model, breakages_),
        keep_(model, breakages_),
        motion_(model, breakages_, bounds.fast),
        energy_(model, breakages_, bounds.kept),
        pulls_(breakages_, bounds.short_loop),
        hands_(schedule.peers.size(), breakages_),
        rest_(schedule, model, breakages_) {}

  /// Names the hostile peer. Its messages are not judged, only their effects on the others.
  void SetHostile(PeerId peer) {
    hostile_ = peer;
    wire_.SetHostile(peer);
    authority_.SetHostile(peer);
    keep_.SetHostile(peer);
    motion_.SetHostile(peer);
  }
  void Wished(PeerId peer, std::int64_t now_ns) { keep_.Wished(peer, now_ns); }

  void OnState(PeerId from, const ObjectState& state) override {
    if (from == hostile_) return;
    wire_.OnState(from, state);
    authority_.OnState(from, state);
  }
  void OnLinks(PeerId from, const CouplingLinks& links) override { wire_.OnLinks(from, links); }
  void OnView(PeerId from, const ViewFrame& view) override { wire_.OnView(from, view); }
  void OnPeerInfo(PeerId from, const PeerInfo& info) override {
    if (from != hostile_) wire_.OnPeerInfo(from, info);
  }
  void OnEvent(PeerId from, const Event& event) override {
    if (from == hostile_) return motion_.OnHostileEvent(event);
    wire_.OnEvent(from, event);
    ++events_[static_cast<std::size_t>(event.kind)];
  }

  /// Notes new conditions of the link from `from` to `to`.
  void LinkSwitched(std::size_t from, std::size_t to, const LinkConditions& link) {
    wire_.LinkSwitched(from, to, link);
  }
  void ClockStepped(std::size_t peer, double step_ms) { wire_.ClockStepped(peer, step_ms); }
  /// Judges what the hand of a scheduled peer gets in this frame.
  void Felt(std::size_t peer, const Wrench& F_D_W) {
    hands_.Felt(peer, schedule_->peers[peer].id, F_D_W);
  }
  /// Call it before every frame.
  void SetTime(std::int64_t now_ns) noexcept { breakages_.SetTime(now_ns); }
  /// Judges a frame; call it after every frame.
  void Look(SimulatedSession& session) {
    authority_.Look(session);
    keep_.Look(session);
    motion_.Look(session);
    energy_.Look(session);
    pulls_.Look(session);
  }
  /// Judges the end, when the faults are over, the hands rest and enough time has passed. `member`
  /// is the number in the session of each scheduled peer; -1: it never came.
  void LookAtEnd(SimulatedSession& session, const std::vector<int>& member, const Viewer& viewer) {
    constexpr std::int64_t kBeginNs = 1'000'000'000;  // true time of the first frame
    authority_.LookAtEnd(session, kBeginNs + 1'000'000 * schedule_->faults_end_ms);
    pulls_.LookAtEnd();
    rest_.Look(session, member, hands_, viewer);
  }
  void NeverAtRest() { breakages_.Add("hands do not come to rest", 0); }
  /// Judges the links; call it later, when the longest silence is forgotten.
  void LookAtLinks(SimulatedSession& session) { rest_.LookAtLinks(session, wire_); }

  const Breakages& breakages() const noexcept { return breakages_; }
  /// Returns the collection for checkers outside this one.
  Breakages& breakages() noexcept { return breakages_; }
  /// Returns how many events of a kind have been on the wire.
  std::uint64_t events(EventKind kind) const { return events_[static_cast<std::size_t>(kind)]; }

 private:
  const FaultSchedule* schedule_;
  Breakages breakages_;
  WireChecker wire_;
  AuthorityChecker authority_;
  KeepChecker keep_;
  PeerId hostile_ = 0;
  MotionChecker motion_;
  EnergyChecker energy_;
  PullChecker pulls_;
  HandChecker hands_;
  RestChecker rest_;
  std::array<std::uint64_t, 5> events_{};
};

}  // namespace tandem
