#include "engine/contact/plane_mean.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace tandem {

namespace {

/// Cosine between the normals of pieces of one face, at least.
constexpr double kSameFace = 0.85;
/// A face that the vertex stands over with this weight counts in full.
constexpr double kFullWeight = 0.1;
/// Voxels: nearer to an edge its faces push.
constexpr double kOnTheEdge = 1e-6;
/// Faces, their pairs and their triples.
constexpr std::size_t kMostSupports = 14;

/// A support of the vertex: a face, the edge of two, or the corner of three.
struct Support {
  std::uint32_t faces = 0;  // a bit each
  PlaneMean::Push push;
};

/// What the vertex has under it where the planes of some faces meet: the way from there to the
/// vertex, if it lies between the faces' normals; else nothing.
template <int n>
bool MeetingOf(const std::array<const PlaneMean::Push*, n>& faces, PlaneMean::Push& push) {
  Eigen::Matrix<double, n, n> cosines;
  Eigen::Matrix<double, n, 1> gaps;
  push.share = 1.0;
  for (int i = 0; i < n; ++i) {
    const PlaneMean::Push& face = *faces[static_cast<std::size_t>(i)];
    for (int k = 0; k < n; ++k) {
      cosines(i, k) = face.normal.dot(faces[static_cast<std::size_t>(k)]->normal);
    }
    gaps[i] = face.gap;
    push.share = std::min(push.share, face.share);
  }
  const Eigen::Matrix<double, n, n> inverse = cosines.inverse();
  const Eigen::Matrix<double, n, 1> along = inverse * gaps;
  if (!(along.minCoeff() > 0)) return false;
  push.gap = std::sqrt(std::max(0.0, along.dot(gaps)));
  if (!(push.gap > kOnTheEdge)) return false;
  push.normal = Vec3::Zero();
  for (int i = 0; i < n; ++i) {
    push.normal += along[i] / push.gap * faces[static_cast<std::size_t>(i)]->normal;
  }
  push.normal.normalize();
  return true;
}

/// How much `other` takes over from `support`: all where it is farther below the vertex. Faces that
/// the vertex is behind share where they are about as far, so that no push turns round at once.
double TakenBy(const Support& other, const Support& support) {
  const double higher = other.push.gap - support.push.gap;
  const double inside = -std::max(other.push.gap, support.push.gap);
  const double width = std::min(kTakeOver, inside);
  if (width <= 0) return higher > 0 ? 1.0 : 0.0;
  return std::clamp(0.5 + higher / (2 * width), 0.0, 1.0);
}

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

void PlaneMean::AddRidge(const Vec3& place, const std::array<Vec3, 2>& normals,
                         const std::array<double, 2>& heights, const std::array<double, 2>& weights,
                         const std::array<bool, 2>& facing) noexcept {
  // beside the edge only the face that the vertex is above has a say
  const double cosine = normals[0].dot(normals[1]);
  const bool over_edge = heights[0] > cosine * heights[1] && heights[1] > cosine * heights[0];
  const double higher = heights[0] - heights[1];
  const bool inside = std::max(heights[0], heights[1]) < 0 && std::abs(higher) < 2 * kTakeOver;
  for (std::size_t i = 0; i < 2; ++i) {
    if ((over_edge && (facing[0] || facing[1])) ||
        (facing[i] && (inside || (higher > 0) == (i == 0)))) {
      Add(place, normals[i], heights[i], weights[i]);
    }
  }
}

std::size_t PlaneMean::Resolve(const Ridges& ridges,
                               std::array<Push, kMostPushes>& pushes) const noexcept {
  std::array<Support, kMostSupports> supports;
  std::array<Vec3, kMostFaces> places;
  std::array<std::uint32_t, kMostFaces> convex{};  // with which others a face meets in a ridge
  std::size_t count = 0;
  for (; count < count_; ++count) {
    const Face& face = faces_[count];
    places[count] = face.place / face.weight;
    supports[count].faces = 1U << count;
    supports[count].push = {face.normal.normalized(), face.height / face.weight,
                            std::min(1.0, face.weight / kFullWeight)};
  }
  for (std::size_t a = 0; a < count_; ++a) {
    convex[a] |= 1U << a;
    for (std::size_t b = 0; b < a; ++b) {
      const Vec3 apart = places[b] - places[a];
      // known, or each behind the other's plane
      const auto* const end = ridges.normals.begin() + ridges.count;
      const bool ridge = std::any_of(ridges.normals.begin(), end, [&](const auto& normals) {
        const Vec3& one = faces_[a].first;
        const Vec3& two = faces_[b].first;
        return (one.dot(normals[0]) > kSameFace && two.dot(normals[1]) > kSameFace) ||
               (one.dot(normals[1]) > kSameFace && two.dot(normals[0]) > kSameFace);
      });
      const bool behind =
          apart.dot(supports[a].push.normal) <= 0 && apart.dot(supports[b].push.normal) >= 0;
      if (!ridge && !behind) continue;
      convex[a] |= 1U << b;
      convex[b] |= 1U << a;
    }
  }
  for (std::size_t a = 0; a < count_; ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      if ((convex[a] >> b & 1U) == 0) continue;
      const Push* const one = &supports[a].push;
      const Push* const two = &supports[b].push;
      if (MeetingOf<2>({one, two}, supports[count].push)) {
        supports[count++].faces = 1U << a | 1U << b;
      }
      for (std::size_t c = 0; c < b; ++c) {
        if ((convex[a] & convex[b] & 1U << c) == 0) continue;
        if (MeetingOf<3>({one, two, &supports[c].push}, supports[count].push)) {
          supports[count++].faces = 1U << a | 1U << b | 1U << c;
        }
      }
    }
  }
  const auto all_convex = [&](std::uint32_t faces) {
    for (std::size_t a = 0; a < count_; ++a) {
      if ((faces >> a & 1U) != 0 && (faces & ~convex[a]) != 0) return false;
    }
    return true;
  };
  std::size_t pushing = 0;
  for (std::size_t i = 0; i < count && pushing < kMostPushes; ++i) {
    double share = supports[i].push.share;
    for (std::size_t k = 0; k < count; ++k) {
      if (k == i || !all_convex(supports[i].faces | supports[k].faces)) continue;
      // what the vertex hardly stands over cannot take all of what it stands over squarely
      const double of =
          supports[k].push.share / std::max(supports[i].push.share, supports[k].push.share);
      share *= 1.0 - of * TakenBy(supports[k], supports[i]);
    }
    if (share <= 0) continue;
    pushes[pushing] = supports[i].push;
    pushes[pushing++].share = share;
  }
  return pushing;
}

}  // namespace tandem
