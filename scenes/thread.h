#pragma once

#include <vector>

#include "scenes/shapes.h"

namespace tandem {

/// A right-handed helical ridge about z on a round surface, of trapezoidal section (ISO 2904): a
/// bolt's thread where the crest is farther out than the foot, a nut's where it is farther in. Over
/// its first and last turn the ridge has no height, and over half a turn beside these it rises.
struct Thread {
  double pitch = 0;
  double foot_radius = 0;
  double crest_radius = 0;
  double foot_width = 0;   // along z
  double crest_width = 0;  // along z
  double start = 0;        // z of the ridge's middle where it begins, on the x axis
  int turns = 0;           // 3 at least, with the first and the last
  int sides = 0;           // of a turn
};

/// The loops of `below`, the last of which is a circle of the foot's radius, the thread, and the
/// loops of `above`, the first of which is one, too: a solid. Loops have `sides` points, the first
/// of a circle on the x axis. A circle has to be clear of the ridge's feet. kCapped: a bolt;
/// kJoined: the last loop above goes on to the first below, which makes a nut.
TriangleMesh Threaded(const Thread& thread, const std::vector<Loop>& below,
                      const std::vector<Loop>& above, SkinEnds ends);

}  // namespace tandem
