#pragma once

#include <cstdint>
#include <string>

#include "collab/lab/results_file.h"

namespace tandem {

/// What tells a cell of a sweep from others, in words for a table.
struct CellFacts {
  std::string scene;
  std::size_t users = 2;
  std::string hands;       // "off", or "off + heavy", with their grasps
  std::string hand_kinds;  // the same without
  double grasp_m = 0;      // farthest of the hands' own grasps from the centre of mass
  double delay_s = 0;
  std::string network;         // its name, or what is on the line: "jitter 20 ms, loss 5 %"
  std::string network_detail;  // both, where a network has both
  double publish_hz = 0;
  std::string law;  // "p+d", "p+d x 0.5", "constant 200 N/m + 10 N s/m"
  bool gate = false;
  std::string motion;
  std::uint64_t seed = 1;
  std::string map;        // all but the delay and the stiffness: cells of one map share it
  std::string grasp_map;  // all but the grasps and the stiffness, likewise
  std::string but_seed;   // all but the seed: cells that are repeated share it
};

CellFacts FactsOf(const CellRecord& record);

/// One line: "cell 12: free, 2 users, hands heavy, 100 ms, clean, 1000 Hz, p+d,
/// kick".
std::string LineOf(const CellRecord& record, const CellFacts& facts);

/// Stiffness of all links of a user, N/m: by the law, or as measured where no
/// law says it.
double StiffnessOf(const CellRecord& record, const CellFacts& facts);

/// Growth as pictures show it, 1/s. A course that ended long ago, at either side, has no slope
/// left: what swings at its bounds no longer grows (infinite), what is at rest no longer falls
/// (minus infinite).
double ShownGrowth(const CaseResult& result);

/// 12.3: so many digits in all as a table needs, "-" for what is no number.
std::string TableNumber(double value);

}  // namespace tandem
