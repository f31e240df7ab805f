#include "engine/contact/plane_mean.h"

#include <algorithm>

namespace tandem {

namespace {

/// Cosine between the normals of pieces of one face, at least.
constexpr double kSameFace = 0.85;
/// A face that the vertex stands over with this weight counts in full.
constexpr double kFullWeight = 0.25;
/// Voxels: over this difference of height one face of a convex edge takes over from the other.
constexpr double kTakeOver = 0.15;

}  // namespace

void PlaneMean::Add(const Vec3& place, const Vec3& normal, double height, double weight) noexcept {
  if (weight <= 0) return;
  auto* const end = faces_.begin() + count_;
  auto* face = std::find_if(faces_.begin(), end, [&](const Face& f) {
    return f.first.dot(normal) > kSameFace;
  });
  if (face == end) {
    if (count_ == kMostFaces) return;
    faces_[count_++] = {};
    face->first = normal;
  }
  face->normal += weight * normal;
  face->place += weight * place;
  face->height += weight * height;
  face->weight += weight;
}

std::size_t PlaneMean::Resolve(std::array<Push, kMostFaces>& pushes) const noexcept {
  std::array<Vec3, kMostFaces> places;
  for (std::size_t a = 0; a < count_; ++a) {
    const Face& face = faces_[a];
    places[a] = face.place / face.weight;
    pushes[a].normal = face.normal.normalized();
    pushes[a].gap = face.height / face.weight;
    pushes[a].share = std::min(1.0, face.weight / kFullWeight);
  }
  for (std::size_t a = 0; a < count_; ++a) {
    for (std::size_t b = 0; b < count_; ++b) {
      const Vec3 apart = places[b] - places[a];
      // each behind the other's plane: the edge between them is convex
      if (a == b || apart.dot(pushes[a].normal) > 0 || apart.dot(pushes[b].normal) < 0) continue;
      const double higher = pushes[b].gap - pushes[a].gap;
      // a face that the vertex hardly stands over cannot take over
      const double taken = std::clamp(0.5 + higher / (2 * kTakeOver), 0.0, 1.0);
      pushes[a].share *= 1.0 - taken * std::min(1.0, faces_[b].weight / kFullWeight);
    }
  }
  return count_;
}

}  // namespace tandem
