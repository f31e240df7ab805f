#pragma once

#include "engine/contact/pair/contact_pair.h"

namespace tandem {

/// The price of telling how far a point may be from contact, ns of processor time a point. One way
/// is a look-up in the map. The other is the drift of its block since the last look-up (paper §5.2,
/// where the first takes seven times the second).
struct TestPrices {
  double looked_up_ns = 0;
  double drifted_ns = 0;
};

/// Measures both for all points of a pair where they were last tested, on one thread.
TestPrices MeasureTestPrices(const ContactPair& pair);

}  // namespace tandem
