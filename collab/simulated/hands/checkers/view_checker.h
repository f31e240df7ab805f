#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "collab/controller/control_server.h"
#include "collab/simulated/checkers/violations.h"
#include "engine/world/world.h"

namespace tandem {

/// The true holders of each body, and since when they are unchanged everywhere.
struct TrueHolders {
  std::vector<std::vector<PeerId>> of;  // indexed by moving body, ids rising
  std::int64_t since_ns = 0;
  /// Time after which all peers know them.
  std::int64_t known_after_ns = 0;
};

/// Judges what hosts see, and bodies that the hand lets go of.
///
/// - A host that is there gets a snapshot at least every 2 s, from its first message on. It has
///   every body, finite, where the simulation has it in that frame.
/// - The holders in a snapshot are the true ones, where these have not changed for as long as news
///   need.
/// - A released body stays where it is while this peer answers for it and nobody holds it. A shared
///   body must stay only from when the peer has heard of others' releases.
class ViewChecker {
 public:
  ViewChecker(PeerId id, const WorldModel& model, Violations& violations)
      : id_(id), model_(&model), violations_(&violations) {}

  void OnHost(HostId host, std::int64_t now_ns) { seen_ns_.try_emplace(host, now_ns); }
  void OnHostGone(HostId host) { seen_ns_.erase(host); }
  void OnSnapshot(const std::vector<HostId>& hosts, const ControllerSnapshot& snapshot,
                  const TrueHolders& holders, std::int64_t now_ns);
  /// Notes that the controller, or a host, has stood still until now.
  void OnWoken(std::int64_t now_ns);
  void OnWoken(HostId host, std::int64_t now_ns) { seen_ns_[host] = now_ns; }

  /// Judges a frame of that number; call it after every frame. `parked` marks the moving bodies
  /// that this peer answers for and that nobody holds.
  void Check(std::uint64_t frame, const World& world, int held, const std::vector<bool>& parked,
             std::int64_t now_ns);

 private:
  static constexpr std::size_t kKept = 128;  // frames
  static constexpr std::int64_t kMostNs = 2'000'000'000;
  static constexpr std::int64_t kNewsNs = 1'000'000'000;  // until the peer has heard of a release

  void CheckBodies(const ControllerSnapshot& snapshot);
  void CheckHolders(const ControllerSnapshot& snapshot, const TrueHolders& holders,
                    std::int64_t now_ns);

  PeerId id_;
  const WorldModel* model_;
  Violations* violations_;
  std::map<HostId, std::int64_t> seen_ns_;  // time of the newest snapshot, by host
  struct Frame {
    std::uint64_t number = 0;
    std::vector<Pose> poses;
    int held = -1;
  };
  std::array<Frame, kKept> frames_;
  struct Left {
    bool watched = false;
    Pose X_WB;  // pose where it was let go of
    std::int64_t from_ns = 0;
  };
  std::vector<Left> left_;
  int held_ = -1;
};

}  // namespace tandem
