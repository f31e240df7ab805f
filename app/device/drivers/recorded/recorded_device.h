#pragma once

#include <filesystem>
#include <vector>

#include "engine/haptics/device.h"

namespace tandem {

/// A hand that plays the poses of a recording, one each frame, from the user's beginning on. It
/// rests in the last pose, and ignores forces.
class RecordedDevice : public Device {
 public:
  /// Ten minutes; a recording's later frames are not played.
  static constexpr std::size_t kMostFrames = 600'000;

  /// Reads the poses of a recording. Errors: it is no recording, or it has no frame.
  static Result<std::vector<Anchor>> PosesOf(const std::filesystem::path& recording);

  /// `poses`: at least one.
  explicit RecordedDevice(std::vector<Anchor> poses) : poses_(std::move(poses)) {}

  void Start() noexcept override { started_ = true; }
  Anchor Read() noexcept override;
  void Render(const Wrench&) noexcept override;
  DeviceCapabilities capabilities() const noexcept override;

 private:
  std::vector<Anchor> poses_;
  std::size_t frame_ = 0;
  bool started_ = false;
};

}  // namespace tandem
