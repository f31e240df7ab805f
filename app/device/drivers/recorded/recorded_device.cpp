#include "app/device/drivers/recorded/recorded_device.h"

#include <algorithm>
#include <optional>

#include "collab/recording/recording.h"

namespace tandem {

Result<std::vector<Anchor>> RecordedDevice::PosesOf(const std::filesystem::path& recording) {
  Result<RecordingReader> reader = RecordingReader::Open(recording);
  if (!reader) return reader.error();
  std::vector<Anchor> poses;
  while (poses.size() < kMostFrames) {
    const std::optional<RecordedFrame> frame = reader->Next();
    if (!frame) break;
    poses.push_back(frame->device);
  }
  if (poses.empty()) return Error{recording.string() + ": the recording has no frame"};
  return poses;
}

Anchor RecordedDevice::Read() noexcept {
  Anchor handle = poses_[frame_];
  if (!started_ || frame_ + 1 == poses_.size()) handle.V_WA = {};
  return handle;
}

void RecordedDevice::Render(const Wrench&) noexcept {
  if (started_) frame_ = std::min(frame_ + 1, poses_.size() - 1);
}

DeviceCapabilities RecordedDevice::capabilities() const noexcept {
  DeviceCapabilities can;
  can.freedoms_out = 0;
  return can;
}

}  // namespace tandem
