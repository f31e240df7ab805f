#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/judgement/nearest_body.h"
#include "collab/peer/peer_node.h"
#include "engine/contact/field/pressed_depth.h"
#include "engine/world/world_model.h"

namespace tandem {

/// The pose of the body in hand, in one frame.
struct HeldPose {
  int body = -1;  // index into WorldModel::bodies; -1: the hand is empty
  Pose X_WB;
};

/// Records which bodies contact pushed while they were in the hand. The haptic thread writes it in
/// every frame, and it is read when that thread has ended. Poses cannot tell this, because some are
/// left out.
class TouchedBodies {
 public:
  explicit TouchedBodies(std::size_t bodies) : met_(bodies, false) {}
  /// Takes a frame that has ended. `body`: the body in the hand, or -1.
  void See(const World& world, int body) noexcept;
  bool operator[](std::size_t body) const noexcept { return met_[body]; }

 private:
  std::vector<bool> met_;
};

/// Returns the index of the body in the hand of a node, into WorldModel::bodies; -1: none. For the
/// haptic thread.
int HeldBody(PeerNode& node) noexcept;

/// The place of a moving body at the end.
struct FinalPose {
  Pose X_WB;
  bool pushing = false;  // contact pushes it there
};

/// Returns the last places of all moving bodies, in the order of WorldModel::bodies. Call it when
/// the haptic thread has ended.
std::vector<FinalPose> FinalPoses(const World& world);

/// The verdict on a body that a hand held.
struct BodyVerdict {
  std::string body;
  double moved = 0;         // m, displacement of its centre of mass at the end
  double farthest = 0;      // m, largest displacement of the poses in hand and of the end
  std::optional<bool> out;  // its box has left that of all fixed bodies; nothing: no body is fixed
  bool was_out = false;     // `out` at the pose in hand that was farthest
  bool met = false;         // contact pushed it while it was held
  /// m, greatest depth in fixed bodies over the poses judged; nothing: not judged, or none is fixed
  std::optional<double> deepest;
  double deepest_error = 0;  // m, by which it may be deeper at that pose
  double voxel_size = 0;     // m
  /// How contact of the body gives way; nothing: contact was off.
  std::optional<ContactYield> yield;
  std::size_t poses_judged = 0;
  /// The body from which contact holds it at its last place, and the distance; nothing: no contact
  /// there, or surfaces that meet, or not judged.
  std::optional<NearestBody> held_from;
};

/// Keeps the poses of a run to be judged at its end. When there are kMost, it leaves out every
/// second one, and so on. So the kept poses are spread evenly over the run. It takes all memory at
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
inline constexpr double kHurriedVerdictSeconds = 0.1;  // for a program that a signal ends

/// Judges the bodies that were in hand, in the order of their first poses, by exact geometry and
/// against the fixed bodies. `last`: places of all moving bodies. A body that touched nothing has
/// gone into nothing, unless `contact_off`. `peak_force` (N): the greatest of the hand, which may
/// press more than kHandForce. Takes at most `seconds` of search for each body. Of scenes above
/// 300,000 triangles neither penetration nor gaps are judged.
std::vector<BodyVerdict> Judge(const WorldModel& model, const HeldPoses& poses,
                               const TouchedBodies& met, const std::vector<FinalPose>& last,
                               bool contact_off, double peak_force,
                               double seconds = kVerdictSeconds);

/// Returns one line for a person: "peg stands 60.0 mm from its first place and is out; it never
/// went into what is fixed". Motion by others' hands counts too.
std::string Describe(const BodyVerdict& verdict);

/// Returns "contact holds it 0.38 mm from hole; a smaller voxel_m lets it nearer".
std::string DescribeGap(const NearestBody& held_from);

/// Returns "went 0.40 mm ± 0.01 mm into fixed bodies (0.80 voxels)". `error` (m): by which the
/// depth may be greater.
std::string DescribePenetration(double depth, double error, double voxel_size);

/// Returns an object for each verdict: body, moved_mm, farthest_mm, out, was_out, met, deepest_mm,
/// deepest_tolerance_mm, poses_judged, held_from, held_from_mm, pressed_mm, voxel_m_decides.
nlohmann::ordered_json AsJson(const std::vector<BodyVerdict>& verdicts);

}  // namespace tandem
