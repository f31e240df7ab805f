#pragma once

#include "engine/geometry/mesh/triangle_mesh.h"
#include "scenes/generators/large/random_source.h"

namespace tandem {

/// Returns a random machine part: flanged pipe, gear train, ribbed housing, bracket, perforated
/// plates, spring strut, cylinder, bolt and nut, ball bearing, tank, rack and pinion, bundle of
/// hoses. It is about the origin and about 250 mm long; its bodies do not overlap.
TriangleMesh PartByChance(RandomSource& rng);

/// Returns a beam of I section along x from 0 to `length` about the axis, with ribs and rows of
/// bolts (mm).
TriangleMesh Beam(double length, double height, double width, RandomSource& rng);

/// Returns a pipe along that curve with flanges every few points where it runs straight (mm).
TriangleMesh PipeRun(const std::vector<Vec3>& points, double radius, RandomSource& rng);

}  // namespace tandem
