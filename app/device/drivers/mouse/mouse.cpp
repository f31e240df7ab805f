#include <atomic>
#include <cmath>
#include <memory>
#include <string>

#include "app/device/drivers/driver_table.h"
#include "app/device/drivers/event_source.h"
#include "app/device/drivers/rate_hand_driver.h"

namespace tandem::driver {
namespace {

constexpr double kSmoothSeconds = 0.01;  // time constant in which a count's displacement is used up
constexpr double kTickSeconds = 1e-3;
constexpr double kWheelCounts = 40;  // counts that a click of the wheel is worth
constexpr const char* kNoMouse = "the mouse is unplugged: plug it in";

/// The driver `mouse`: any mouse of the machine moves the hand while a button is held, whichever
/// window has the focus.
class Mouse : public RateHandDriver {
 public:
  static constexpr const char* kName = "mouse";
  static constexpr const char* kKind = "mouse of this machine, without a window";
  static constexpr const char* kOptions =
      "hold=middle|right|side|none,mm_per_count=MM,deg_per_count=DEGREES,path=FILE";

  static std::int32_t List(TandemDeviceFound* found, std::int32_t room) {
    return EventSource::List(found, room, IsMouse, kName);
  }
  static std::unique_ptr<Mouse> Open(const char* text, const TandemDeviceHost& host,
                                     std::string& fault) {
    Options options(text);
    std::unique_ptr<Mouse> mouse(new Mouse(host));
    const std::string hold = options.Text("hold", "middle");
    mouse->way_ = 1e-3 * options.Number("mm_per_count", 0.05, 0.001, 10);
    mouse->turn_ = M_PI / 180 * options.Number("deg_per_count", 0.1, 0.001, 10);
    const std::string path = options.Text("path");
    fault = options.Fault();
    mouse->hold_ = hold == "middle"  ? BTN_MIDDLE
                   : hold == "right" ? BTN_RIGHT
                   : hold == "side"  ? BTN_SIDE
                                     : kAlways;
    if (fault.empty() && mouse->hold_ == kAlways && hold != "none") {
      fault = "hold: expected middle, right, side or none, got '" + hold + "'";
    }
    if (fault.empty()) fault = mouse->source_.Open(path, IsMouse, kName);
    return fault.empty() ? std::move(mouse) : nullptr;
  }

  std::string Start() {
    source_.Start();
    return {};
  }
  std::string Trouble() const { return gone_.load() ? kNoMouse : ""; }

  std::int32_t Read(TandemDeviceState& state) noexcept {
    const bool is_there = source_.Take([this](const input_event& event) {
      Take(event);
    });
    gone_.store(!is_there);
    if (!is_there) {
      held_ = turns_ = false;
      hand_.Rest();
      return TANDEM_UNPLUGGED;
    }
    hand_.Move(Vec3::Zero(), Vec3::Zero(), host_->now_ns());
    hand_.Tell(state);
    return TANDEM_OK;
  }

 private:
  static constexpr int kAlways = -1;

  explicit Mouse(const TandemDeviceHost& host) : RateHandDriver(host) {}

  void Take(const input_event& event) noexcept {
    if (event.type == EV_SYN && event.code == SYN_DROPPED) {
      // events were lost: asks which buttons are down
      held_ = hold_ != kAlways && source_.IsDown(hold_);
      turns_ = source_.IsDown(BTN_LEFT);
      return;
    }
    if (event.type == EV_KEY) {
      if (event.code == hold_) held_ = event.value != 0;
      if (event.code == BTN_LEFT) turns_ = event.value != 0;
      return;
    }
    if (event.type != EV_REL || !(held_ || hold_ == kAlways)) return;
    // V: right, up, to the person; the wheel moves away from the person
    const double count = event.value;
    if (event.code == REL_X) {
      Add(Vec3(count, 0, 0), Vec3(0, count, 0));
    } else if (event.code == REL_Y) {
      Add(Vec3(0, -count, 0), Vec3(count, 0, 0));
    } else if (event.code == REL_WHEEL) {
      Add(Vec3(0, 0, -kWheelCounts * count), Vec3(0, 0, kWheelCounts * count));
    }
  }
  void Add(const Vec3& way, const Vec3& turn) noexcept {
    if (turns_) {
      hand_.Add(Vec3::Zero(), turn_ * turn);
    } else {
      hand_.Add(way_ * way, Vec3::Zero());
    }
  }

  EventSource source_;
  int hold_ = BTN_MIDDLE;
  double way_ = 0;   // m for each count
  double turn_ = 0;  // rad for each count
  std::atomic<bool> gone_{false};

  // used by the loop alone
  bool held_ = false;
  bool turns_ = false;
};

}  // namespace
}  // namespace tandem::driver

const TandemDriver tandem_driver = tandem::driver::DriverTable<tandem::driver::Mouse>::Table();
