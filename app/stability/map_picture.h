#pragma once

#include <string>
#include <vector>

#include "app/picture/picture.h"
#include "collab/lab/metrics.h"

namespace tandem {

/// Says which quantity a map has from left to right.
enum class MapAxis : std::uint8_t {
  kDelay,  // s, logarithmic
  kGrasp   // m from the body's centre of mass to where a hand holds it
};

/// One experiment on a map of stiffness over delay or grasp.
struct MapCell {
  double x = 0;          // by the map's axis
  double stiffness = 0;  // N/m, all links of a user
  double growth = 0;     // 1/s; infinite: it blew up
  Verdict verdict = Verdict::kUndecided;
  std::string hint;
};

/// Says whose stiffness a line shows over the map's axis: theory's or a law's.
enum class MapLineKind : std::uint8_t {
  kBoundary,    // stable below, exactly, in free space
  kPassive,     // stable below with whatever it touches: b/tau
  kAnyDelay,    // stable below at any delay
  kLaw,         // of the cells, or the default law
  kLinearCalm,  // the paper's, as soft as it must be
  kLinearFirm   // and firmer
};

struct MapLine {
  MapLineKind kind = MapLineKind::kBoundary;
  std::string name;
  std::vector<PicturePoint> points;  // x by the map's axis; N/m
};

struct StabilityMap {
  std::string name;  // of its files
  std::string title;
  std::string note;  // below the title
  std::vector<MapCell> cells;
  std::vector<MapLine> lines;
  MapAxis axis = MapAxis::kDelay;
  std::vector<std::string> details = {};  // of the note: what the title may have to name
};

/// The growth at which the colours end, either way, 1/s.
inline constexpr double kMostGrowth = 2.0;

/// Blue where it dies out, white at none, red where it grows; grey for what is
/// no number. Readable without red and green.
Rgb GrowthColour(double growth);

/// Where the axes of the map begin and end, around all its cells: x by its axis, and N/m.
struct MapRange {
  double least_x = 0;
  double most_x = 0;
  double softest = 0;
  double firmest = 0;
};
MapRange RangeOf(const StabilityMap& map);

/// Delay or grasp from left to right, stiffness upwards, logarithmic; each cell a
/// tile in the colour of its growth with a mark for what was measured, the
/// lines above.
Picture PictureOf(const StabilityMap& map);

}  // namespace tandem
