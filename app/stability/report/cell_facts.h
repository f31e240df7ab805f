#pragma once

#include <cstdint>
#include <string>

#include "collab/lab/sweep/results_file.h"

namespace tandem {

/// The parameters that distinguish a cell of a sweep, in words for a table.
struct CellFacts {
  std::string scene;
  std::size_t users = 2;
  std::string hands;       // "off", or "off + heavy", with their grasps
  std::string hand_kinds;  // the same without grasps
  double grasp_m = 0;      // largest distance of a hand's own grasp from the centre of mass
  double delay_s = 0;
  std::string network;         // network's name, or its line: "jitter 20 ms, loss 5 %"
  std::string network_detail;  // name and line, where the network has both
  double publish_hz = 0;
  std::string law;  // "p+d", "p+d x 0.5", "constant 200 N/m + 10 N s/m"
  bool gate = false;
  std::string motion;
  std::uint64_t seed = 1;
  std::string map;        // key of the map over delay: all parameters but delay and stiffness
  std::string grasp_map;  // key of the map over grasp: all parameters but grasps and stiffness
  std::string but_seed;   // all parameters but the seed; repeated cells share it
};

CellFacts FactsOf(const CellRecord& record);

/// Describes a cell in a line: "cell 12: free, 2 users, hands heavy, 100 ms, clean, 1000 Hz, p+d,
/// kick".
std::string LineOf(const CellRecord& record, const CellFacts& facts);

/// Returns the stiffness of all links of a user, N/m: as the law predicts it, or as measured where
/// the law does not.
double StiffnessOf(const CellRecord& record, const CellFacts& facts);

/// Returns the growth that pictures show, 1/s. Motion that swings at its bounds shows infinite
/// growth, and a body at rest shows minus infinity, though the measured slope is about zero in
/// both.
double ShownGrowth(const CaseResult& result);

/// Formats a number in the digits that a table needs, such as 12.3. Infinite: "any". NaN: "-".
std::string TableNumber(double value);

}  // namespace tandem
