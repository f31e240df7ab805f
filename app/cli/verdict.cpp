#include "app/cli/verdict.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "app/cli/demo_judgement.h"
#include "app/cli/talk.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr double kVerdictSeconds = 1.0;
constexpr std::size_t kMostJudgedTriangles = 300'000;

std::size_t TrianglesOf(const WorldModel& model) {
  std::size_t triangles = 0;
  for (const TriangleMesh& mesh : model.meshes_W) triangles += mesh.triangles.size();
  return triangles;
}

}  // namespace

int HeldBody(PeerNode& node) noexcept {
  const RigidState* const held = node.peer().held_state();
  for (std::size_t b = 0; b < node.world().model().bodies.size(); ++b) {
    if (&node.world().state(b) == held) return static_cast<int>(b);
  }
  return -1;
}

void BodiesMet::See(const World& world, int body) noexcept {
  if (body < 0) return;
  const auto index = static_cast<std::size_t>(body);
  if (!met_[index] && world.Touched(index)) met_[index] = true;
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
                               const BodiesMet& met, const std::vector<Pose>& last_WB,
                               bool contact_off) {
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
    verdict.met = met[body];
    std::vector<std::vector<Pose>> series(1);
    for (const HeldPose& pose : poses.kept()) {
      if (pose.body == static_cast<int>(body)) series[0].push_back(pose.X_WB);
    }
    const Outcome outcome = OutcomeOf(model, body, last_WB[body]);
    verdict.moved = outcome.travel;
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
      const PenetrationReport report = Penetration(model, body, series, voxel, kVerdictSeconds);
      verdict.poses_judged = report.poses_checked;
      verdict.deepest = report.max_penetration_voxels * voxel;
    }
  }
  return verdicts;
}

std::string DescribePenetration(double depth, double voxel_size) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "went %.2f mm into what is fixed (%.2f voxels)",
                1e3 * depth, depth / voxel_size);
  return text.data();
}

std::string Describe(const BodyVerdict& verdict) {
  std::array<char, 48> moved{};
  std::snprintf(moved.data(), moved.size(), " moved %.1f mm", 1e3 * verdict.moved);
  std::string line = verdict.body + moved.data();
  if (!verdict.out) return line + "; nothing is fixed that it could be out of";
  line += *verdict.out ? " and is out" : " and is NOT out";
  if (!verdict.deepest) return line + "; how deep it went into what is fixed is not judged";
  if (verdict.poses_judged == 0) return line + "; it touched nothing";
  const std::string judged = ", by " + Counted(verdict.poses_judged, "pose") + " of its way";
  // a hundredth of a voxel is the rounding of what it rests on
  if (*verdict.deepest > 0.01 * verdict.voxel_size) {
    return line + "; it " + DescribePenetration(*verdict.deepest, verdict.voxel_size) + judged;
  }
  return line + "; it never went into what is fixed" + judged;
}

nlohmann::ordered_json AsJson(const std::vector<BodyVerdict>& verdicts) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const BodyVerdict& verdict : verdicts) {
    nlohmann::ordered_json row{{"body", verdict.body},  {"moved_mm", 1e3 * verdict.moved},
                               {"out", nullptr},        {"met", verdict.met},
                               {"deepest_mm", nullptr}, {"poses_judged", verdict.poses_judged}};
    if (verdict.out) row["out"] = *verdict.out;
    if (verdict.deepest) row["deepest_mm"] = 1e3 * *verdict.deepest;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace tandem
