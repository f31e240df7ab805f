#include "app/device/drivers/openhaptics/hd.h"

#include <vector>

namespace tandem::driver {

namespace {

constexpr int kMostErrors = 32;  // errors read at most; more are of no interest

int RankOf(unsigned code) {
  if (code == 0) return 0;
  if (IsForceError(code)) return 1;
  if (IsRefused(code)) return 2;
  return IsGone(code) ? 4 : 3;
}

}  // namespace

unsigned Worse(unsigned one, unsigned other) {
  return RankOf(other) > RankOf(one) ? other : one;
}

unsigned TakeErrors(const Hd& hd) {
  unsigned worst = 0;
  for (int i = 0; i < kMostErrors; ++i) {
    const unsigned code = hd.GetError().code;
    if (code == 0) break;
    worst = Worse(worst, code);
  }
  return worst;
}

std::string LoadHd(const std::string& file, Hd& hd) {
  // once in a process, since the library must not be loaded twice
  static VendorLibrary library;
  static std::string loaded;
  if (!library.loaded()) {
    const std::vector<std::string> files =
        file.empty() ? std::vector<std::string>{"libHD.so", "libHD.so.3.4", "libHD.so.3.0"}
                     : std::vector<std::string>{file};
    library = {};
    // global, since libHD loads the device's own driver, which uses its symbols
    if (!library.Load(files, true)) return library.why();
    loaded = file;
  } else if (loaded != file) {
    return "another libHD is loaded in this process";
  }
  library.Take(hd.InitDevice, "hdInitDevice");
  library.Take(hd.DisableDevice, "hdDisableDevice");
  library.Take(hd.MakeCurrentDevice, "hdMakeCurrentDevice");
  library.Take(hd.BeginFrame, "hdBeginFrame");
  library.Take(hd.EndFrame, "hdEndFrame");
  library.Take(hd.GetError, "hdGetError");
  library.Take(hd.GetErrorString, "hdGetErrorString");
  library.Take(hd.GetString, "hdGetString");
  library.Take(hd.GetDoublev, "hdGetDoublev");
  library.Take(hd.GetIntegerv, "hdGetIntegerv");
  library.Take(hd.SetDoublev, "hdSetDoublev");
  library.Take(hd.Enable, "hdEnable");
  library.Take(hd.CheckCalibration, "hdCheckCalibration");
  library.Take(hd.UpdateCalibration, "hdUpdateCalibration");
  library.Take(hd.StartScheduler, "hdStartScheduler");
  library.Take(hd.StopScheduler, "hdStopScheduler");
  library.Take(hd.SetSchedulerRate, "hdSetSchedulerRate");
  library.Take(hd.ScheduleAsynchronous, "hdScheduleAsynchronous");
  library.Take(hd.Unschedule, "hdUnschedule");
  if (library.missing().empty()) return {};
  return "the library has no function " + library.missing() + ": install OpenHaptics 3";
}

}  // namespace tandem::driver
