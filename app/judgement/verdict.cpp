#include "app/judgement/verdict.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "app/common/console.h"
#include "app/judgement/demo_judgement.h"
#include "app/judgement/start_gaps.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr std::size_t kMostJudgedTriangles = 300'000;
constexpr double kRounding = 0.01;  // voxels; at a smaller distance surfaces meet

std::size_t TrianglesOf(const WorldModel& model) {
  std::size_t triangles = 0;
  for (const TriangleMesh& mesh : model.meshes_W) triangles += mesh.triangles.size();
  return triangles;
}

/// Returns the pose that is farthest from the first place. `poses` must not be empty.
const Pose& FarthestOf(const std::vector<Pose>& poses, const Pose& X_WB0) {
  return *std::ranges::max_element(poses, {}, [&X_WB0](const Pose& X_WB) {
    return (X_WB.p - X_WB0.p).squaredNorm();
  });
}

/// Returns the body that contact keeps a body away from; nothing: contact lets the surfaces meet.
std::optional<NearestBody> HeldFrom(const WorldModel& model, std::size_t body,
                                    const std::vector<FinalPose>& last) {
  if (!last[body].pushing || TrianglesOf(model) > kMostJudgedTriangles) return std::nullopt;
  std::vector<Pose> bodies_WB;
  for (const FinalPose& place : last) bodies_WB.push_back(place.X_WB);
  // contact does not reach so far, not even in the plain model
  const double at_most = 2 * ContactBegins(model.scene, 0);
  auto nearest = NearestTo(model, body, bodies_WB, at_most);
  if (nearest && nearest->distance <= kRounding * model.scene.voxel_size) return std::nullopt;
  return nearest;
}

}  // namespace

int HeldBody(PeerNode& node) noexcept {
  const RigidState* const held = node.peer().held_state();
  for (std::size_t b = 0; b < node.world().model().bodies.size(); ++b) {
    if (&node.world().state(b) == held) return static_cast<int>(b);
  }
  return -1;
}

void TouchedBodies::See(const World& world, int body) noexcept {
  if (body < 0) return;
  const auto index = static_cast<std::size_t>(body);
  if (!met_[index] && world.Touched(index)) met_[index] = true;
}

std::vector<FinalPose> FinalPoses(const World& world) {
  std::vector<FinalPose> last;
  for (std::size_t b = 0; b < world.model().bodies.size(); ++b) {
    last.push_back({.X_WB = world.state(b).X_WB, .pushing = world.Touched(b)});
  }
  return last;
}

void HeldPoses::Add(const HeldPose& pose) {
  if (given_++ % stride_ != 0) return;
  kept_.push_back(pose);
  if (kept_.size() < kMost) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < kept_.size(); i += 2) kept_[kept++] = kept_[i];
  kept_.resize(kept);
  stride_ *= 2;
}

std::vector<BodyVerdict> Judge(const WorldModel& model, const HeldPoses& poses,
                               const TouchedBodies& met, const std::vector<FinalPose>& last,
                               bool contact_off, double peak_force, double seconds) {
  std::vector<std::size_t> bodies;
  for (const HeldPose& pose : poses.kept()) {
    const auto body = static_cast<std::size_t>(pose.body);
    if (pose.body >= 0 && std::ranges::count(bodies, body) == 0) bodies.push_back(body);
  }
  std::vector<BodyVerdict> verdicts;
  for (const std::size_t body : bodies) {
    BodyVerdict& verdict = verdicts.emplace_back();
    verdict.body = model.bodies[body].name;
    verdict.voxel_size = model.scene.voxel_size;
    if (!contact_off) {
      verdict.yield =
          YieldOf(model.scene, model.scene.bodies[model.object[body]].inward_shift_voxels);
      verdict.yield->force = std::max(kHandForce, peak_force);
    }
    verdict.met = met[body];
    std::vector<std::vector<Pose>> series(1);
    for (const HeldPose& pose : poses.kept()) {
      if (pose.body == static_cast<int>(body)) series[0].push_back(pose.X_WB);
    }
    const Outcome outcome = OutcomeOf(model, body, last[body].X_WB);
    verdict.moved = outcome.travel;
    const Outcome farthest =
        OutcomeOf(model, body, FarthestOf(series[0], model.bodies[body].X_WB0));
    verdict.farthest = std::max(farthest.travel, outcome.travel);
    verdict.was_out = model.has_fixture && farthest.out;
    verdict.held_from = HeldFrom(model, body, last);
    if (!model.has_fixture) continue;
    verdict.out = outcome.out;
    if (!verdict.met && !contact_off) {
      verdict.deepest = 0;
    } else if (TrianglesOf(model) <= kMostJudgedTriangles) {
      TriangleMesh part;
      for (std::size_t i = 0; i < model.meshes_W.size(); ++i) {
        if (model.body_index[i] == static_cast<int>(body)) Append(part, model.meshes_W[i]);
      }
      const double voxel = SampledVoxel(part, model.scene.voxel_size);
      const PenetrationReport report = Penetration(model, body, series, voxel, seconds);
      verdict.poses_judged = report.poses_checked;
      verdict.deepest = report.max_penetration_voxels * voxel;
      verdict.deepest_error = report.overlapping_poses > 0 ? report.error_voxels * voxel : 0;
    }
  }
  return verdicts;
}

namespace {

/// Returns a value to so many digits behind the point, and at least one of the last.
double RoundedUp(double value, int digits) {
  const double unit = std::pow(10.0, -digits);
  return unit * std::max(1.0, std::ceil(value / unit));
}

}  // namespace

std::string DescribeGap(const NearestBody& held_from) {
  std::array<char, 32> gap{};
  std::snprintf(gap.data(), gap.size(), "%.2g", 1e3 * held_from.distance);
  return std::string("contact holds it ") + gap.data() + " mm from " + held_from.name +
         "; a smaller voxel_m lets it come nearer";
}

std::string DescribePenetration(double depth, double error, double voxel_size) {
  std::array<char, 120> text{};
  // the hundredth of a millimetre is too coarse for a small voxel
  const int digits = depth < 1e-4 ? 3 : 2;
  std::snprintf(text.data(), text.size(),
                "went %.*f mm \u00b1 %.*f mm into fixed bodies (%.2f voxels)", digits, 1e3 * depth,
                digits, RoundedUp(1e3 * error, digits), depth / voxel_size);
  return text.data();
}

namespace {

std::string Millimetres(double metres) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f mm", 1e3 * metres);
  return text.data();
}

/// Returns what a hand's body went into, and how deep.
std::string DescribeDepth(const BodyVerdict& verdict) {
  if (!verdict.deepest) return "its depth in fixed bodies is not judged";
  if (verdict.poses_judged == 0) return "it touched nothing";
  const std::string judged = ", by " + WithPlural(verdict.poses_judged, "pose") + " of its way";
  if (*verdict.deepest > kRounding * verdict.voxel_size) {
    return "it " +
           DescribePenetration(*verdict.deepest, verdict.deepest_error, verdict.voxel_size) +
           judged + (verdict.yield ? "; " + verdict.yield->Describe(*verdict.deepest) : "");
  }
  return "it never went into fixed bodies" + judged;
}

}  // namespace

std::string Describe(const BodyVerdict& verdict) {
  std::string line = verdict.body;
  const std::string stands = " stands " + Millimetres(verdict.moved) + " from its first place";
  if (!verdict.out) {
    line += stands + "; the scene has no fixed body that it could come out of";
  } else if (*verdict.out) {
    line += stands + " and is out; " + DescribeDepth(verdict);
  } else if (verdict.was_out) {
    line += " was " + Millimetres(verdict.farthest) +
            " from its first place at the farthest, and out; at the end it is back, " +
            Millimetres(verdict.moved) + " from there; " + DescribeDepth(verdict);
  } else {
    line += stands + " and is NOT out; " + DescribeDepth(verdict);
  }
  if (verdict.held_from) line += "; " + DescribeGap(*verdict.held_from);
  return line;
}

nlohmann::ordered_json AsJson(const std::vector<BodyVerdict>& verdicts) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const BodyVerdict& verdict : verdicts) {
    nlohmann::ordered_json row{{"body", verdict.body},
                               {"moved_mm", 1e3 * verdict.moved},
                               {"farthest_mm", 1e3 * verdict.farthest},
                               {"out", nullptr},
                               {"was_out", verdict.was_out},
                               {"met", verdict.met},
                               {"deepest_mm", nullptr},
                               {"deepest_tolerance_mm", nullptr},
                               {"poses_judged", verdict.poses_judged},
                               {"held_from", nullptr},
                               {"held_from_mm", nullptr},
                               {"pressed_mm", nullptr},
                               {"voxel_m_decides", nullptr}};
    if (verdict.yield) {
      const double pressed = verdict.yield->PressedDepth();
      const double deepest = verdict.deepest.value_or(0);
      row["pressed_mm"] = 1e3 * pressed;
      if (deepest > kRounding * verdict.voxel_size && deepest <= pressed) {
        row["voxel_m_decides"] = verdict.yield->VoxelThatDecides(deepest);
      }
    }
    if (verdict.out) row["out"] = *verdict.out;
    if (verdict.deepest) {
      row["deepest_mm"] = 1e3 * *verdict.deepest;
      row["deepest_tolerance_mm"] = 1e3 * verdict.deepest_error;
    }
    if (verdict.held_from) {
      row["held_from"] = verdict.held_from->name;
      row["held_from_mm"] = 1e3 * verdict.held_from->distance;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace tandem
