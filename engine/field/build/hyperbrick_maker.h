#pragma once

#include <array>

#include "engine/field/build/built_bricks.h"
#include "engine/field/build/face_tree.h"
#include "engine/field/build/field_builder.h"
#include "engine/field/build/field_mesh.h"
#include "engine/field/build/near_faces.h"

namespace tandem {

/// Makes the bricks and the bounds of one hyperbrick from its near faces.
class HyperbrickMaker {
 public:
  /// `first`: the hyperbrick's lowest node. All of these must outlive it.
  HyperbrickMaker(const FieldOptions& options, const FieldMesh& mesh, const GridIndex& first,
                  BuiltHyperbrick& hyperbrick)
      : options_(options), mesh_(mesh), first_(first), hyperbrick_(hyperbrick) {}

  void Make();

 private:
  /// Tells whether places of the free side have readings farther off than the survey of a
  /// hyperbrick sees.
  bool HasFarBricks() const { return options_.range > DistanceField::kLeastRange; }
  void MakeBricks();
  /// Makes the bricks of the free side that are farther off than a survey sees, in a cube of the
  /// hyperbrick (in cells from the hyperbrick's first).
  void MakeFarBricks(const GridIndex& from, int side, FarNodes& nodes);
  /// Fills a brick by measuring the faces, and tells whether it comes near enough to be kept.
  bool MeasureBrick(const NearFaces& faces, const HyperbrickSurvey& survey, double kept,
                    FarNodes& far_nodes, BuiltBrick& brick);
  std::array<bool, kBrickNodes> SolidNodes(const GridIndex& lowest,
                                           const NearestLanes& nodes) const;
  /// Gives a bound to the places without a brick in a cube of a hyperbrick (in cells from the
  /// hyperbrick's first). It is one bound for all where that is at least a third of their distance.
  /// Returns whether it is one bound.
  bool BoundCube(const GridIndex& from, int side);

  const FieldOptions& options_;
  const FieldMesh& mesh_;
  GridIndex first_;
  BuiltHyperbrick& hyperbrick_;
};

}  // namespace tandem
