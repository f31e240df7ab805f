#pragma once

#include "engine/contact/contact_pair.h"

namespace tandem {

/// What the two ways take to tell how far a point may be from contact, ns of processor time a
/// point: by look-up in the map, or by how far its block has drifted since (paper §5.2, where the
/// one took seven times the other).
struct TestPrices {
  double looked_up_ns = 0;
  double drifted_ns = 0;
};

/// Of all points of a pair where they were last tested, one thread.
TestPrices MeasureTestPrices(const ContactPair& pair);

}  // namespace tandem
