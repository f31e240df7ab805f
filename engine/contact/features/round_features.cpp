#include "engine/contact/features/round_features.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/contact/features/crown_points.h"

namespace tandem {

namespace {

/// Voxels that a round surface may stand out from its triangles. More would be felt.
constexpr double kMostSagitta = 0.05;
/// Voxels that a vertex may lie beside its round surface.
constexpr double kMostOff = 0.01;
constexpr double kLeastRadius = 1;  // voxels
constexpr double kMargin = 0.05;    // voxels
/// The least cosine between a feature's outward normal and the round surface's. The rims of a
/// cylinder face half away from it.
constexpr double kFacesOut = 0.5;

bool LiesOn(const RoundSurface& round, const Vec3& place, const Vec3& outward) {
  Vec3 from = place - round.centre;
  const double along = from.dot(round.axis);
  if (!round.is_sphere()) {
    if (std::abs(along) > round.half_length + kMostOff) return false;
    from -= along * round.axis;
  }
  const double out = from.norm();
  const double least = round.radius - round.sagitta - kMostOff;
  return out >= least && out <= round.radius + kMostOff && outward.dot(from) >= kFacesOut * out;
}

}  // namespace

RoundFeatures FindRoundFeatures(const TriangleMesh& mesh_W, const Vec3& p_WVo, double voxel_size,
                                const BodyFeatures& features) {
  std::vector<RoundSurface> surfaces =
      FindRoundSurfaces(mesh_W, {.most_sagitta = kMostSagitta * voxel_size,
                                 .most_off = kMostOff * voxel_size,
                                 .least_radius = kLeastRadius * voxel_size});
  RoundFeatures found;
  if (surfaces.empty()) return found;
  for (RoundSurface& round : surfaces) {
    round.centre = (round.centre - p_WVo) / voxel_size;
    for (double* length : {&round.radius, &round.half_length, &round.sagitta}) {
      *length /= voxel_size;
    }
  }
  // a surface that curves the other way, as a hole does, has no features that face out of it
  std::vector<std::uint8_t> of_point(BodyFeatures::kLanes * features.blocks().size(),
                                     RoundFeatures::kNone);
  for (std::size_t r = 0; r < surfaces.size(); ++r) {
    if (found.rounds.size() == RoundFeatures::kMostRounds) return {};
    bool any = false;
    for (std::size_t block = 0; block < features.blocks().size(); ++block) {
      for (std::size_t lane = 0; lane < BodyFeatures::kLanes; ++lane) {
        const Vec3 outward = -features.point(block, lane).inward.cast<double>();
        if (!LiesOn(surfaces[r], features.place(block, lane), outward)) continue;
        of_point[BodyFeatures::kLanes * block + lane] =
            static_cast<std::uint8_t>(found.rounds.size());
        any = true;
      }
    }
    if (!any) continue;
    // twice as high, the cap holds several features, whose weights are not small
    const double cap = 2 * (surfaces[r].sagitta + kMostStandingOut) + kMargin;
    const bool ball = surfaces[r].is_sphere();
    found.rounds.push_back(
        {surfaces[r], ball ? Vec3(Vec3::Zero()) : surfaces[r].axis.unitOrthogonal(), cap});
    found.most_cap = std::max(found.most_cap, cap);
  }
  if (!found.rounds.empty()) found.of_point = std::move(of_point);
  return found;
}

}  // namespace tandem
