#pragma once

#include <vector>

#include "app/picture/picture.h"
#include "engine/realtime/histogram.h"

namespace tandem {

/// Holds the forces and contacts of a removal, frame by frame from its first.
struct RemovalTrace {
  struct Frame {
    float contact_N = 0;  // contact force on the part
    float hand_N = 0;
    int contacts = 0;
  };
  std::vector<Frame> frames;  // one frame for each millisecond
};

/// Draws three pictures. `removal_times` shows the share of frames that took longer than a time, at
/// 1 kHz and as the least of passes. `removal_contacts` and `removal_force` show the course in
/// time.
std::vector<Picture> RemovalPictures(const RemovalTrace& trace, const Histogram& at_1khz,
                                     const Histogram& least);

}  // namespace tandem
