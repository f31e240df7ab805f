#include "app/device/drivers/recorded/recorded.h"

#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "app/device/drivers/exported_device.h"
#include "app/device/drivers/recorded/recorded_device.h"

namespace tandem {
namespace {

constexpr double kMostGap =
    0.02;  // m; a larger distance from the part to the hand's first place is reported

struct RecordedHand {
  static constexpr const char* kName = "recorded";
  static constexpr const char* kKind = "hand of a recording ('tandem peer --record')";
  static constexpr const char* kOptions = "RECORDING";
  static Result<std::unique_ptr<Device>> Open(const std::string& file, const Pose& X_WB0) {
    if (file.empty()) return Error{"no recording is given: write recorded:FILE"};
    Result<std::vector<Anchor>> poses = RecordedDevice::PosesOf(file);
    if (!poses) return poses.error();
    const double gap = (poses->front().X_WA.p - X_WB0.p).norm();
    if (gap > kMostGap) {
      std::fprintf(stderr, "device: the recorded hand begins %.0f mm from the part's centre\n",
                   1000 * gap);
    }
    return std::unique_ptr<Device>(std::make_unique<RecordedDevice>(*std::move(poses)));
  }
};

}  // namespace

const TandemDriver kRecordedDriver = driver::ExportedDevice<RecordedHand>::Table();

}  // namespace tandem
