#include "app/view/model/proximity/proximity_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/geometry/mesh/weld.h"

namespace tandem {

namespace {

/// Merges equal vertices: drawing has one for each smooth side, connectivity needs one alone.
TriangleMesh MeshOf(const ShadedMesh& shaded) {
  std::vector<FloatPoint> points;
  points.reserve(shaded.vertices.size());
  for (const ShadedMesh::Vertex& vertex : shaded.vertices) points.push_back(vertex.p);
  const Weld weld = WeldEqual(points);
  TriangleMesh mesh;
  for (const std::uint32_t first : weld.first_point) {
    mesh.vertices.emplace_back(points[first][0], points[first][1], points[first][2]);
  }
  const auto corner = [&](std::size_t i) {
    return weld.vertex_of_point[shaded.triangles[i]];
  };
  for (std::size_t i = 0; i < shaded.triangles.size(); i += 3) {
    mesh.triangles.push_back({corner(i), corner(i + 1), corner(i + 2)});
  }
  return mesh;
}

std::array<std::uint8_t, 4> Bytes(const Colour& colour) {
  const auto byte = [](float x) {
    return static_cast<std::uint8_t>(std::lround(255 * x));
  };
  return {byte(colour[0]), byte(colour[1]), byte(colour[2]), 255};
}

}  // namespace

std::string DistanceText(const SceneNearness& nearest, const ContactYield& yield) {
  if (nearest.overlap && !(nearest.depth > 0)) return "overlap";
  if (nearest.overlap) {
    char depth[64];
    std::snprintf(depth, sizeof depth, "overlap, at least %.3f mm deep; ", 1e3 * nearest.depth);
    return depth + yield.Brief(nearest.depth);
  }
  const double error_mm = 1e-3 * std::max(1.0, std::ceil(1e6 * nearest.error_bound()));
  char text[64];
  std::snprintf(text, sizeof text, "%.3f mm \u00b1 %.3f mm", 1e3 * nearest.distance, error_mm);
  return text;
}

std::vector<ProximityBody> ProximityBodiesOf(const DrawnScene& scene) {
  std::vector<ProximityBody> bodies;
  for (const DrawnBody& body : scene.bodies) {
    bodies.push_back({body.name, body.look.fixed, MeshOf(body.mesh), body.look.part_of});
  }
  return bodies;
}

ProximityComposer::ProximityComposer(std::shared_ptr<const DrawnScene> scene,
                                     std::vector<ProximityPart> parts)
    : scene_(std::move(scene)),
      proximity_(std::make_shared<const std::vector<ProximityPart>>(std::move(parts))),
      centres_(kMostShadow) {
  for (std::size_t part = 0; part < proximity_.parts().size(); ++part) {
    if (proximity_.parts()[part].fixed) continue;
    for (const std::size_t body : proximity_.parts()[part].bodies) {
      ColouredBody& coloured = coloured_.emplace_back(ColouredBody{part, body, {}});
      for (const ShadedMesh::Vertex& vertex : scene_->bodies[body].mesh.vertices) {
        coloured.points_W.push_back(vertex.p);
      }
    }
  }
}

bool ProximityComposer::IsHeld(std::size_t part, std::span<const std::size_t> held) const {
  const std::vector<std::size_t>& bodies = proximity_.parts()[part].bodies;
  return std::find_first_of(bodies.begin(), bodies.end(), held.begin(), held.end()) != bodies.end();
}

ContactYield ProximityComposer::YieldOf(std::size_t part) const {
  const Scene& scene = scene_->source;
  const std::size_t body = proximity_.parts()[part].bodies.front();
  const bool known = body < scene.bodies.size();
  return {.contact = scene.contact,
          .force_layer = scene.force_layer,
          .inward_shift_voxels = known ? scene.bodies[body].inward_shift_voxels : 0,
          .voxel_size = scene_->voxel_size};
}

ProximityPicture ProximityComposer::Compose(std::span<const Pose> X_W,
                                            std::span<const std::size_t> held) {
  ProximityPicture picture;
  picture.voxel_size = static_cast<float>(scene_->voxel_size);
  picture.range = proximity_.range();
  for (const ColouredBody& coloured : coloured_) {
    distances_.resize(coloured.points_W.size());
    proximity_.Distances(coloured.part, coloured.points_W, X_W, distances_);
    VertexColours colours{coloured.body, {}};
    colours.rgba.reserve(distances_.size());
    for (const float distance : distances_) {
      colours.rgba.push_back(Bytes(ProximityColour(static_cast<double>(distance), picture.range)));
    }
    picture.bodies.push_back(std::move(colours));
  }
  const ShadowCount shadow = proximity_.Shadow(X_W, kShadowVoxels * scene_->voxel_size, centres_);
  picture.shadow_found = shadow.found;
  picture.shadow_W.reserve(shadow.written);
  for (std::size_t i = 0; i < shadow.written; ++i) {
    const Eigen::Vector3f centre = centres_[i].cast<float>();
    picture.shadow_W.push_back({centre.x(), centre.y(), centre.z()});
  }
  picture.nearest = proximity_.Nearest(X_W, {.depth = true});
  if (picture.nearest.other != SceneNearness::kNone) {
    picture.part = proximity_.parts()[picture.nearest.part].name;
    picture.other = proximity_.parts()[picture.nearest.other].name;
    picture.yield = YieldOf(picture.nearest.part);
  }
  if (picture.nearest.other == SceneNearness::kNone || IsHeld(picture.nearest.part, held) ||
      IsHeld(picture.nearest.other, held)) {
    return picture;
  }
  for (std::size_t part = 0; part < proximity_.parts().size(); ++part) {
    if (proximity_.parts()[part].fixed || !IsHeld(part, held)) continue;
    const SceneNearness near = proximity_.NearestTo(part, X_W, {.depth = true});
    if (near.other == SceneNearness::kNone) continue;
    const bool first = picture.of_held.other == SceneNearness::kNone;
    const SceneNearness& nearest = picture.of_held;
    // among several overlaps the deepest counts
    const bool nearer = near.distance < nearest.distance ||
                        (near.overlap && nearest.overlap && near.depth > nearest.depth);
    if (!first && !nearer) continue;
    picture.of_held = near;
    picture.held_part = proximity_.parts()[near.part].name;
    picture.held_other = proximity_.parts()[near.other].name;
    picture.held_yield = YieldOf(near.part);
  }
  return picture;
}

}  // namespace tandem
