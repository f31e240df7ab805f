#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/cli/path_distance.h"
#include "engine/base/result.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Voxels by which surfaces may come nearer than the clearance that a hand is said to have: the
/// room that refined contact needs in a narrow fit (decision 0041).
inline constexpr double kKeptToVoxels = 0.05;

/// The room that the hand of a recording had (paper §3.2).
struct HandRoom {
  std::int64_t frames = 0;
  bool torn = false;            // the file ends within a frame
  bool contact = true;          // bodies were solid
  NearestPlace nearest;         // along the recorded poses; below 0: so deep
  std::optional<bool> crosses;  // the surfaces; nothing: they meet, and depth is not judged
  double at_s = 0;              // of `nearest`, from the recording's first frame
  /// m, the greatest clearance with which the same hand moves the part to where it ended; nothing:
  /// it does not even with none, or bodies were not solid
  std::optional<double> passes_with;
  bool at_least = false;  // `passes_with` is the most that a hand's clearance can be enlarged by
  std::optional<double> kept;  // m, least exact distance along the path with that clearance
};

/// Measures along the poses of a recording. Then replays the recorded hand with larger clearances
/// and bisects the greatest that passes, to 0.01 voxel. A clearance passes if two things hold:
///
/// - The bodies that were held end where the recording has them end: a part that is out of all that
///   is fixed anywhere out, any other within a voxel or 2 mm, the greater, of its last pose.
/// - Their exact surfaces never came nearer to others than the clearance less kKeptToVoxels. In a
///   narrow fit refined contact gives way (decision 0041), so that a part gets out in any case.
///
/// The hand goes where it went, and what the peer heard from others stays as recorded. Takes about
/// ten times what one replay takes. `on_trial` is told of each clearance (m) and whether it passes.
///
/// `model`: the recorded scene with the recorded voxels. Errors: the file cannot be read or is
/// damaged, a frame does not end in its recorded bits, the hand held nothing.
Result<HandRoom> MeasureHandRoom(const std::filesystem::path& file,
                                 const std::shared_ptr<const WorldModel>& model,
                                 const std::function<void(double, bool)>& on_trial = {});

}  // namespace tandem
