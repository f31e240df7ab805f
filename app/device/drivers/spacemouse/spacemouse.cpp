#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <thread>

#include "app/device/drivers/driver_table.h"
#include "app/device/drivers/rate_hand_driver.h"
#include "app/device/drivers/spacemouse/daemon_link.h"
#include "app/device/drivers/spacemouse/puck.h"
#include "app/device/drivers/trouble.h"
#include "engine/realtime/seqlock.h"

namespace tandem::driver {
namespace {

constexpr int kTurnMs = 50;  // time between two checks whether to end
constexpr std::chrono::milliseconds kAskEvery{1000};
constexpr std::chrono::milliseconds kFirstRetry{100};
constexpr std::chrono::milliseconds kLastRetry{3200};
constexpr const char* kNoDaemon = "spacenavd does not answer at ";
constexpr const char* kMendDaemon = "apt install spacenavd && systemctl start spacenavd";
constexpr const char* kNoPuck = "no SpaceMouse is plugged in";
constexpr const char* kMendPuck =
    "plug it in; 'journalctl -u spacenavd' shows what the daemon sees";

/// The driver `spacemouse`.
class SpaceMouse : public RateHandDriver {
 public:
  static constexpr const char* kName = "spacemouse";
  static constexpr const char* kKind = "SpaceMouse of 3Dconnexion, by spacenavd";
  static constexpr const char* kOptions =
      "mode=object|camera,dominant=yes|no,speed_mm_s=MM,turn_deg_s=DEGREES,dead_zone=SHARE,"
      "clutch=BUTTON,stop=BUTTON,socket=FILE";

  static std::int32_t List(TandemDeviceFound* found, std::int32_t room) {
    if (room < 1) return 0;
    DaemonLink link;
    const std::string socket = DaemonLink::DefaultSocket();
    if (!link.Connect(socket).empty()) {
      Put(found->missing, kNoDaemon + socket);
      Put(found->mend, kMendDaemon);
    } else if (link.AskDevices([](const DaemonEvent&) {}) != DaemonLink::Devices::kSome) {
      Put(found->missing, kNoPuck);
      Put(found->mend, kMendPuck);
    } else {
      found->present = 1;
      Put(found->name, "SpaceMouse");
    }
    return 1;
  }

  static std::unique_ptr<SpaceMouse> Open(const char* text, const TandemDeviceHost& host,
                                          std::string& fault) {
    Options options(text);
    std::unique_ptr<SpaceMouse> mouse(new SpaceMouse(host));
    PuckSettings& puck = mouse->settings_;
    puck.speed = 1e-3 * options.Number("speed_mm_s", 100, 1, 500);
    puck.turn = M_PI / 180 * options.Number("turn_deg_s", 60, 1, 180);
    puck.dead_zone = options.Number("dead_zone", 0.03, 0, 0.5);
    puck.dominant = options.Flag("dominant", false);
    const std::string mode = options.Text("mode", "object");
    puck.moves_camera = mode == "camera";
    mouse->clutch_ = static_cast<int>(options.Number("clutch", 0, -1, 31));
    mouse->stop_ = static_cast<int>(options.Number("stop", -1, -1, 31));
    mouse->socket_ = options.Text("socket", DaemonLink::DefaultSocket());
    fault = options.Fault();
    if (fault.empty() && mode != "object" && mode != "camera") {
      fault = "mode: expected object or camera, got '" + mode + "'";
    }
    if (!fault.empty()) return nullptr;
    if (!mouse->Connect()) {
      fault = kNoDaemon + mouse->socket_ + ": " + kMendDaemon;
      return nullptr;
    }
    return mouse;
  }
  ~SpaceMouse() {
    over_.store(true);
    if (thread_.joinable()) thread_.join();
  }
  SpaceMouse(const SpaceMouse&) = delete;
  SpaceMouse& operator=(const SpaceMouse&) = delete;

  std::string Start() {
    thread_ = std::thread([this] {
      Listen();
    });
    return {};
  }
  std::string Trouble() const { return trouble_.line(); }

  std::int32_t Read(TandemDeviceState& state) noexcept {
    Push push;
    if (push_.Read(push)) newest_ = push;
    if (!newest_.there) {
      hand_.Rest();
      return TANDEM_UNPLUGGED;
    }
    const PuckRates rates = RatesOf(newest_.axes, settings_, dominant_);
    hand_.Move(rates.v, rates.w, host_->now_ns());
    hand_.Tell(state);
    const auto pressed = [this](int button) {
      return button >= 0 && (newest_.buttons >> static_cast<unsigned>(button) & 1U) != 0;
    };
    if (pressed(clutch_)) state.buttons |= TANDEM_BUTTON_CLUTCH;
    if (pressed(stop_)) state.buttons |= TANDEM_BUTTON_STOP;
    return TANDEM_OK;
  }

 private:
  /// The puck's state. The daemon reports changes alone, so the last state holds.
  struct Push {
    bool there = false;
    std::array<std::int32_t, 6> axes{};
    std::uint32_t buttons = 0;
  };

  explicit SpaceMouse(const TandemDeviceHost& host) : RateHandDriver(host) {}

  bool Connect() {
    if (!link_.Connect(socket_).empty()) return false;
    now_ = {};
    return Ask();
  }
  /// Asks the daemon whether there is a device. Returns whether the daemon answers.
  bool Ask() {
    asks_ = false;
    const DaemonLink::Devices devices = link_.AskDevices([this](const DaemonEvent& event) {
      Take(event);
    });
    requested_ = std::chrono::steady_clock::now();
    if (devices == DaemonLink::Devices::kNoAnswer) return false;
    const bool is_there = devices == DaemonLink::Devices::kSome;
    if (!is_there) now_ = {};
    now_.there = is_there;
    Tell();
    return true;
  }
  void Take(const DaemonEvent& event) {
    switch (event.kind) {
      case DaemonEvent::kMotion:
        now_.there = true;
        std::copy_n(event.word.begin(), 6, now_.axes.begin());
        break;
      case DaemonEvent::kPress:
      case DaemonEvent::kRelease: {
        if (event.word[0] < 0 || event.word[0] > 31) return;
        const std::uint32_t bit = 1U << static_cast<unsigned>(event.word[0]);
        now_.buttons = event.kind == DaemonEvent::kPress ? now_.buttons | bit : now_.buttons & ~bit;
        break;
      }
      case DaemonEvent::kDevice:
        // the daemon reports no zero motion of a puck that was pulled out; there may be another
        // puck
        now_ = {};
        now_.there = event.word[0] == 0;
        asks_ = event.word[0] != 0;
        break;
      default:
        return;
    }
    Tell();
  }
  void Tell() {
    trouble_.Say(now_.there ? "" : "no SpaceMouse is plugged in: plug it in");
    push_.Write(now_);
  }
  void Listen() {
    std::chrono::milliseconds retry = kFirstRetry;
    while (!over_.load()) {
      bool is_there = link_.Wait(kTurnMs, [this](const DaemonEvent& event) {
        Take(event);
      });
      // a daemon that hangs would leave the hand at its last rate for ever
      const bool is_due = std::chrono::steady_clock::now() - requested_ > kAskEvery;
      if (is_there && (asks_ || is_due)) is_there = Ask();
      if (is_there) continue;
      link_.Close();
      now_ = {};
      push_.Write(now_);
      trouble_.Say("spacenavd no longer answers: systemctl start spacenavd");
      const auto until = std::chrono::steady_clock::now() + retry;
      while (!over_.load() && std::chrono::steady_clock::now() < until) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
      retry = std::min(2 * retry, kLastRetry);
      if (!over_.load() && Connect()) retry = kFirstRetry;
    }
  }

  PuckSettings settings_;
  int clutch_ = 0;
  int stop_ = -1;
  std::string socket_;
  std::atomic<bool> over_{false};
  std::thread thread_;
  Seqlock<Push> push_;
  driver::Trouble trouble_;

  // used by the thread alone; before it starts, by the main thread
  DaemonLink link_;
  Push now_;
  bool asks_ = false;  // true: ask which devices are there
  std::chrono::steady_clock::time_point requested_{};

  // used by the loop alone
  Push newest_;
  std::size_t dominant_ = 0;
};

}  // namespace
}  // namespace tandem::driver

const TandemDriver tandem_driver = tandem::driver::DriverTable<tandem::driver::SpaceMouse>::Table();
