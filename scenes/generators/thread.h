#pragma once

#include <vector>

#include "scenes/generators/shapes.h"

namespace tandem {

/// A right-handed helical ridge about z on a round surface, of trapezoidal section (ISO 2904). It
/// is a bolt's thread if the crest is farther out than the foot, a nut's if it is farther in. Over
/// its first and last turn the ridge has no height, and over half a turn beside these it rises.
struct Thread {
  double pitch = 0;
  double foot_radius = 0;
  double crest_radius = 0;
  double foot_width = 0;   // along z
  double crest_width = 0;  // along z
  double start = 0;        // z of the ridge's middle at its start, on the x axis
  int turns = 0;           // 3 at least, with the first and the last
  int sides = 0;           // sides of a turn
};

/// Returns a solid from loops and a thread: the loops of `below`, the thread, and the loops of
/// `above`. The last of `below` and the first of `above` are circles of the foot's radius. Loops
/// have `sides` points; the first point of a circle is on the x axis. A circle must be clear of the
/// ridge's feet. kCapped: a bolt. kJoined: the last loop above is joined to the first below, which
/// makes a nut.
TriangleMesh Threaded(const Thread& thread, const std::vector<Loop>& below,
                      const std::vector<Loop>& above, SkinEnds ends);

}  // namespace tandem
