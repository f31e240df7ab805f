#include <algorithm>

#include "engine/contact/refined_contacts.h"

// The map's vertices that points of the shell bear on: all points that are near one have a say in
// where it pushes, so they are met together, after the candidates were looked at one by one.

namespace tandem {

namespace {

constexpr std::int32_t kFar = 1 << 30;

std::size_t HashOf(const GridIndex& voxel) {
  return MortonCode(voxel) * 0x9e3779b97f4a7c15ULL >> 20U;
}

}  // namespace

std::size_t RefinedContacts::SlotFor(const GridIndex& voxel) const noexcept {
  std::size_t slot = HashOf(voxel) & (slots_.size() - 1);
  while (slots_[slot] != 0 && !(met_[slots_[slot] - 1].voxel == voxel)) {
    slot = (slot + 1) & (slots_.size() - 1);
  }
  return slot;
}

void RefinedContacts::FindOrAdd(const GridIndex& voxel, const Vec3& q) noexcept {
  const std::size_t slot = SlotFor(voxel);
  if (slots_[slot] != 0) return;
  if (met_count_ == met_.size()) return;  // more than candidates were planned for
  used_slots_[met_count_] = static_cast<std::uint32_t>(slot);
  met_[met_count_].faces.Clear();
  met_[met_count_].voxel = voxel;
  met_[met_count_].q = q;
  met_[met_count_].ridge = 0;
  slots_[slot] = static_cast<std::uint32_t>(++met_count_);
}

template <class Visit>
void RefinedContacts::BearOn(const Candidate& candidate, const Faces& faces,
                             const Visit& visit) noexcept {
  const Vec3 p = candidate.p_V / s_;
  for (const SurfaceWindow::Piece& piece :
       scratch_[0].window.Near(candidate.voxel_V, Field::kVertex)) {
    Bearing bearing;
    bool bears = false;
    for (std::size_t i = 0; i < faces.count; ++i) {
      const Vec3& n = faces.nhat[i];
      const Over over = StandUnder(piece, p, n);
      bearing.q = over.q;
      bearing.normals[i] = -n;
      bearing.heights[i] = over.height;
      bearing.weights[i] = over.weight;
      bearing.facing[i] = n.dot(FacingNormal(*piece.detail, n)) > kFacing;
      // a face that looks away says nothing, however low it is
      bearing.high =
          bearing.high && (!bearing.facing[i] || over.weight <= 0 || IsHigh(over.height));
      bears = bears || (bearing.facing[i] && over.weight > 0);
    }
    if (bears) visit(piece, bearing);
  }
}

void RefinedContacts::AddMetRidge(const std::array<Vec3, 2>& normals, MetVertex& met) noexcept {
  if (met_ridge_count_ == met_ridges_.size()) return;  // more than candidates were planned for
  met_ridges_[met_ridge_count_] = {normals, met.ridge};
  met.ridge = static_cast<std::uint32_t>(++met_ridge_count_);
}

void RefinedContacts::MeetVertices(std::span<const Candidate> candidates,
                                   const Mat3& R_VS) noexcept {
  // a vertex that all points are high above is not pushed; of others, all points have a say
  GridIndex low{kFar, kFar, kFar};
  GridIndex high{-kFar, -kFar, -kFar};
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if ((found_[i] & kBears) == 0) continue;
    const Faces faces = FacesAt(candidates[i], R_VS);
    BearOn(candidates[i], faces, [&](const SurfaceWindow::Piece& piece, const Bearing& bearing) {
      if (bearing.high) return;
      const GridIndex& v = piece.voxel_V;
      FindOrAdd(v, bearing.q);
      low = {std::min(low.x, v.x - 1), std::min(low.y, v.y - 1), std::min(low.z, v.z - 1)};
      high = {std::max(high.x, v.x + 1), std::max(high.y, v.y + 1), std::max(high.z, v.z + 1)};
    });
  }
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if ((found_[i] & (kBears | kHigh)) == 0) continue;
    const Candidate& candidate = candidates[i];
    const GridIndex& v = candidate.voxel_V;
    if (v.x < low.x || v.y < low.y || v.z < low.z || v.x > high.x || v.y > high.y || v.z > high.z) {
      continue;
    }
    const Faces faces = FacesAt(candidate, R_VS);
    BearOn(candidate, faces, [&](const SurfaceWindow::Piece& piece, const Bearing& b) {
      const std::uint32_t number = slots_[SlotFor(piece.voxel_V)];
      if (number == 0) return;
      MetVertex& met = met_[number - 1];
      const Vec3 p = candidate.p_V / s_;
      if (faces.count == 2) {
        AddMetRidge(b.normals, met);
        met.faces.AddRidge(p, b.normals, b.heights, b.weights, b.facing);
      } else {
        met.faces.Add(p, b.normals[0], b.heights[0], b.weights[0]);
      }
    });
  }
}

std::size_t RefinedContacts::TakeVertices(Contact* out) noexcept {
  std::size_t found = 0;
  PlaneMean::Ridges& ridges = scratch_[0].ridges;
  for (std::size_t i = 0; i < met_count_; ++i) {
    const MetVertex& met = met_[i];
    ridges.count = 0;
    for (std::uint32_t ridge = met.ridge; ridge != 0; ridge = met_ridges_[ridge - 1].before) {
      ridges.Add(met_ridges_[ridge - 1].normals);
    }
    slots_[used_slots_[i]] = 0;
    std::array<PlaneMean::Push, PlaneMean::kMostPushes> pushes;
    const std::size_t pushing = met.faces.Resolve(ridges, pushes);
    for (std::size_t k = 0; k < pushing; ++k) {
      const double depth = (kRefinedClearance - pushes[k].gap) * pushes[k].share;
      if (depth > 0) out[found++] = {s_ * met.q, -pushes[k].normal, s_ * depth};
    }
  }
  met_count_ = 0;
  met_ridge_count_ = 0;
  return found;
}

}  // namespace tandem
