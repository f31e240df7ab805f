#pragma once

#include <string>
#include <vector>

#include "app/picture/picture.h"
#include "collab/lab/metrics/metrics.h"

namespace tandem {

/// The quantity that a map shows from left to right.
enum class MapAxis : std::uint8_t {
  kDelay,  // s, logarithmic
  kGrasp   // m from the body's centre of mass to the hand's grasp
};

/// One experiment on a map of stiffness over delay or grasp.
struct MapCell {
  double x = 0;          // value on the map's axis
  double stiffness = 0;  // N/m, all links of a user
  double growth = 0;     // 1/s; infinite: the run blew up
  Verdict verdict = Verdict::kUndecided;
  std::string hint;
};

/// The meaning of a line on a map: a limit of theory, or the stiffness that a law gives.
enum class MapLineKind : std::uint8_t {
  kBoundary,    // stable below it in free space; exact
  kPassive,     // stable below it in any contact: b/tau
  kAnyDelay,    // stable below it at any delay
  kLaw,         // law of the cells, or the default law
  kLinearCalm,  // paper's linear law with the default stiffness
  kLinearFirm   // paper's linear law with a higher stiffness
};

struct MapLine {
  MapLineKind kind = MapLineKind::kBoundary;
  std::string name;
  std::vector<PicturePoint> points;  // x on the map's axis; y in N/m
};

struct StabilityMap {
  std::string name;  // name of its files
  std::string title;
  std::string note;  // below the title
  std::vector<MapCell> cells;
  std::vector<MapLine> lines;
  MapAxis axis = MapAxis::kDelay;
  std::vector<std::string> details = {};  // parts of the note that titles name where they
                                          // distinguish maps
};

/// growth at which the colours end on both sides, 1/s
inline constexpr double kMostGrowth = 2.0;

/// Returns blue where motion decays, white where it neither grows nor decays, red where it grows;
/// grey for NaN. Readable without telling red from green.
Rgb GrowthColour(double growth);

/// The range of a map's axes, around all its cells: x on the map's axis, and N/m.
struct MapRange {
  double least_x = 0;
  double most_x = 0;
  double softest = 0;
  double firmest = 0;
};
MapRange RangeOf(const StabilityMap& map);

/// Draws a map: delay or grasp from left to right, stiffness upwards on a logarithmic axis. Each
/// cell is a tile in the colour of its growth, with a mark for its verdict. Lines are drawn above
/// the tiles.
Picture PictureOf(const StabilityMap& map);

}  // namespace tandem
