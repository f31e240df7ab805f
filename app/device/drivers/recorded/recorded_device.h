#pragma once

#include <filesystem>
#include <vector>

#include "engine/haptics/device.h"

namespace tandem {

/// A hand that moves as the one of a recording did, from the user's beginning on, a pose a frame.
/// At the end it rests where it came to. It feels nothing.
class RecordedDevice : public Device {
 public:
  /// Ten minutes; what follows in a recording is not played.
  static constexpr std::size_t kMostFrames = 600'000;

  /// Reads the poses of a recording. Errors: no recording, or one without a frame.
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
