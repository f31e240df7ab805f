#pragma once

#include <vector>

#include "app/picture/picture.h"
#include "engine/realtime/histogram.h"

namespace tandem {

/// Holds the forces and contacts of a removal, frame by frame from its first.
struct RemovalTrace {
  struct Frame {
    float contact_N = 0;  // on the part
    float hand_N = 0;
    int contacts = 0;
  };
  std::vector<Frame> frames;  // of 1 ms
};

/// `removal_times`: the share of frames that took longer than so many microseconds, at 1 kHz and as
/// the least of passes; `removal_contacts` and `removal_force`: over the time.
std::vector<Picture> RemovalPictures(const RemovalTrace& trace, const Histogram& at_1khz,
                                     const Histogram& least);

}  // namespace tandem
