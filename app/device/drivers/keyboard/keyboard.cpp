#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <string>

#include "app/device/drivers/driver_table.h"
#include "app/device/drivers/event_source.h"
#include "app/device/drivers/rate_hand_driver.h"

namespace tandem::driver {
namespace {

constexpr const char* kNoKeyboard = "the keyboard is unplugged: plug it in";

/// A key, and the direction along V in which it moves the hand.
struct MovingKey {
  int key;
  int axis;
  double way;
};
constexpr std::array kMovingKeys{MovingKey{KEY_RIGHT, 0, 1},    MovingKey{KEY_LEFT, 0, -1},
                                 MovingKey{KEY_UP, 1, 1},       MovingKey{KEY_DOWN, 1, -1},
                                 MovingKey{KEY_PAGEDOWN, 2, 1}, MovingKey{KEY_PAGEUP, 2, -1}};

/// The driver `keyboard`: arrows and page keys of the machine's keyboard move the hand while the
/// guard key is down; with Shift they turn it.
class Keyboard : public RateHandDriver {
 public:
  static constexpr const char* kName = "keyboard";
  static constexpr const char* kKind = "keyboard of this machine, without a window";
  static constexpr const char* kOptions = "guard=yes|no,speed_mm_s=MM,turn_deg_s=DEGREES,path=FILE";

  static std::int32_t List(TandemDeviceFound* found, std::int32_t room) {
    return EventSource::List(found, room, IsKeyboard, kName);
  }
  static std::unique_ptr<Keyboard> Open(const char* text, const TandemDeviceHost& host,
                                        std::string& fault) {
    Options options(text);
    std::unique_ptr<Keyboard> keyboard(new Keyboard(host));
    keyboard->guards_ = options.Flag("guard", true);
    keyboard->speed_ = 1e-3 * options.Number("speed_mm_s", 50, 1, 500);
    keyboard->turn_ = M_PI / 180 * options.Number("turn_deg_s", 30, 1, 180);
    const std::string path = options.Text("path");
    fault = options.Fault();
    if (fault.empty()) fault = keyboard->source_.Open(path, IsKeyboard, kName);
    return fault.empty() ? std::move(keyboard) : nullptr;
  }

  std::string Start() {
    source_.Start();
    return {};
  }
  std::string Trouble() const { return gone_.load() ? kNoKeyboard : ""; }

  std::int32_t Read(TandemDeviceState& state) noexcept {
    const bool is_there = source_.Take([this](const input_event& event) {
      Take(event);
    });
    gone_.store(!is_there);
    if (!is_there) {
      down_ = {};
      guard_ = shift_ = false;
      hand_.Rest();
      return TANDEM_UNPLUGGED;
    }
    Vec3 way = Vec3::Zero();
    for (std::size_t i = 0; i < kMovingKeys.size(); ++i) {
      if (down_[i]) way[kMovingKeys[i].axis] += kMovingKeys[i].way;
    }
    if (guards_ && !guard_) way.setZero();
    // right and left turn about the upward axis, up and down about the axis to the right
    const Vec3 about(-way.y(), way.x(), -way.z());
    hand_.Move(shift_ ? Vec3(Vec3::Zero()) : Vec3(speed_ * way),
               shift_ ? Vec3(turn_ * about) : Vec3(Vec3::Zero()), host_->now_ns());
    hand_.Tell(state);
    return TANDEM_OK;
  }

 private:
  explicit Keyboard(const TandemDeviceHost& host) : RateHandDriver(host) {}

  void Take(const input_event& event) noexcept {
    if (event.type == EV_SYN && event.code == SYN_DROPPED) {
      // events were lost: asks which keys are down
      for (std::size_t i = 0; i < kMovingKeys.size(); ++i) {
        down_[i] = source_.IsDown(kMovingKeys[i].key);
      }
      guard_ = source_.IsDown(KEY_RIGHTCTRL);
      shift_ = source_.IsDown(KEY_LEFTSHIFT) || source_.IsDown(KEY_RIGHTSHIFT);
      return;
    }
    // 2 is a repetition
    if (event.type != EV_KEY || event.value > 1) return;
    const bool is_down = event.value == 1;
    if (event.code == KEY_RIGHTCTRL) guard_ = is_down;
    if (event.code == KEY_LEFTSHIFT || event.code == KEY_RIGHTSHIFT) shift_ = is_down;
    for (std::size_t i = 0; i < kMovingKeys.size(); ++i) {
      if (event.code == kMovingKeys[i].key) down_[i] = is_down;
    }
  }

  EventSource source_;
  bool guards_ = true;
  double speed_ = 0;  // m/s
  double turn_ = 0;   // rad/s
  std::atomic<bool> gone_{false};

  // used by the loop alone
  std::array<bool, kMovingKeys.size()> down_{};
  bool guard_ = false;
  bool shift_ = false;
};

}  // namespace
}  // namespace tandem::driver

const TandemDriver tandem_driver = tandem::driver::DriverTable<tandem::driver::Keyboard>::Table();
