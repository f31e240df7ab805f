#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/judgement/path_distance.h"
#include "engine/base/result.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Voxels by which surfaces may come nearer than the hand's set clearance. Refined contact needs
/// this room in a narrow fit (decision 0053).
inline constexpr double kKeptToVoxels = 0.05;

/// The room that the hand of a recording had (paper §3.2).
struct HandFreeSpace {
  std::int64_t frames = 0;
  bool torn = false;     // the file ends within a frame
  bool contact = true;   // bodies were solid: contact was on
  NearestPlace nearest;  // nearest place along the recorded poses; distance below 0: depth
  /// True: the surfaces cross. Nothing: they meet, and depth is not judged.
  std::optional<bool> crosses;
  double depth_error = 0;  // m, by which surfaces that cross may be deeper
  double peak_force = 0;   // N, the greatest of the recorded hand
  double at_s = 0;         // time of `nearest`, from the recording's first frame
  /// m, the greatest clearance with which the same hand moves the part to where it ended. Nothing:
  /// none passes, depth was not judged, or bodies were not solid.
  std::optional<double> passes_with;
  bool at_least = false;  // `passes_with` is the most by which a hand's clearance can be enlarged
  std::optional<double> kept;  // m, least exact distance along the path with that clearance
};

/// Measures the distance along the poses of a recording. Then it replays the recorded hand with
/// larger clearances and bisects the greatest that passes, to 0.01 voxel. A clearance passes if two
/// things hold:
///
/// - The held bodies end where the recording has them end. A body that ended out of all fixed
///   bodies may end anywhere out. Any other ends within a voxel or 2 mm, the greater, of its last
///   pose.
/// - The exact surfaces of the held bodies never came nearer to others than the clearance less
///   kKeptToVoxels. Refined contact gives way in a narrow fit (decision 0053), so a part gets out
///   in any case.
///
/// The hand repeats its motion, and what the peer heard from others stays as recorded. Takes about
/// ten times what one replay takes. `on_trial` gets each clearance (m) and whether it passes.
///
/// `model`: the recorded scene with the recorded voxels. Errors: the file cannot be read or is
/// damaged, a frame does not end in its recorded bits, the hand held nothing.
Result<HandFreeSpace> MeasureHandFreeSpace(const std::filesystem::path& file,
                                           const std::shared_ptr<const WorldModel>& model,
                                           const std::function<void(double, bool)>& on_trial = {});

}  // namespace tandem
