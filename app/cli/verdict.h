#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/cli/nearest_body.h"
#include "collab/peer_node.h"
#include "engine/world/world_model.h"

namespace tandem {

/// The pose of the body in hand, in one frame.
struct HeldPose {
  int body = -1;  // into WorldModel::bodies; -1: the hand is empty
  Pose X_WB;
};

/// Which bodies contact pushed while they were in the hand. Written by the haptic thread in every
/// frame, read when that has ended: poses, of which some are left out, cannot tell this.
class BodiesMet {
 public:
  explicit BodiesMet(std::size_t bodies) : met_(bodies, false) {}
  /// After a frame. `body`: in the hand, or -1.
  void See(const World& world, int body) noexcept;
  bool operator[](std::size_t body) const noexcept { return met_[body]; }

 private:
  std::vector<bool> met_;
};

/// The body in the hand of a node, into WorldModel::bodies; -1: none. By the haptic thread.
int HeldBody(PeerNode& node) noexcept;

/// Where a moving body is at the end.
struct LastPlace {
  Pose X_WB;
  bool loaded = false;  // contact pushes it there
};

/// The last places of all moving bodies, in the order of WorldModel::bodies. When the haptic thread
/// has ended.
std::vector<LastPlace> LastPlaces(const World& world);

/// What became of a body that a hand held.
struct BodyVerdict {
  std::string body;
  double moved = 0;         // m, its centre of mass at the end, from its first place
  double farthest = 0;      // m, the same of the pose in hand that was farthest
  std::optional<bool> out;  // its box has left that of all that is fixed; nothing: nothing is fixed
  bool was_out = false;     // the same at the farthest
  bool met = false;         // contact pushed it while it was held
  /// m, in what is fixed, of the poses judged; nothing: not judged, or nothing is fixed
  std::optional<double> deepest;
  double voxel_size = 0;  // m
  std::size_t poses_judged = 0;
  /// The body to which contact does not let it come at its last place, and how far it is; nothing:
  /// no contact there, or surfaces that meet, or not judged.
  std::optional<NearestBody> held_from;
};

/// The poses of a run that are kept to be judged at its end. Beyond kMost of them every second one
/// is left out, and so on: what is kept is spread evenly over the run. All memory is taken at
/// construction.
class HeldPoses {
 public:
  static constexpr std::size_t kMost = 60'000;

  HeldPoses() { kept_.reserve(kMost); }
  void Add(const HeldPose& pose);
  const std::vector<HeldPose>& kept() const noexcept { return kept_; }

 private:
  std::vector<HeldPose> kept_;
  std::size_t stride_ = 1;
  std::size_t given_ = 0;
};

inline constexpr double kVerdictSeconds = 1.0;
inline constexpr double kHurriedVerdictSeconds = 0.1;  // where a signal ends the program

/// Judges the bodies that were in hand, in the order of their first poses, by exact geometry and
/// against what is fixed. `last`: of all moving bodies. What touched nothing has gone into nothing,
/// but with `contact_off`. Takes `seconds` of search at the most; neither penetration nor gaps of
/// scenes above 300,000 triangles are judged.
std::vector<BodyVerdict> Judge(const WorldModel& model, const HeldPoses& poses,
                               const BodiesMet& met, const std::vector<LastPlace>& last,
                               bool contact_off, double seconds = kVerdictSeconds);

/// One line for a person: "peg stands 60.0 mm from its first place and is out; it never went into
/// what is fixed". Who else had moved it does not matter.
std::string Describe(const BodyVerdict& verdict);

/// "contact holds it 0.38 mm from hole; a smaller voxel_m lets it nearer"
std::string DescribeGap(const NearestBody& held_from);

/// "went 0.40 mm into what is fixed (0.80 voxels)"
std::string DescribePenetration(double depth, double voxel_size);

/// An object for each: body, moved_mm, farthest_mm, out, was_out, met, deepest_mm, poses_judged,
/// held_from, held_from_mm.
nlohmann::ordered_json AsJson(const std::vector<BodyVerdict>& verdicts);

}  // namespace tandem
