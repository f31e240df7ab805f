#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "app/device/drivers/inverse3/messages.h"
#include "app/device/drivers/inverse3/websocket.h"
#include "app/device/drivers/trouble.h"
#include "app/device/tandem_device.h"
#include "engine/realtime/seqlock.h"

namespace tandem::driver::inverse3 {

/// The ports of the service, and the rate of messages.
struct Place {
  int port = 10001;
  int events_port = 10020;  // 0: do not listen to events
  double rate_hz = 1000;
};

/// The newest known state of the handle.
struct Reading {
  std::uint64_t number = 0;  // number of the message
  std::int32_t condition = TANDEM_UNPLUGGED;
  std::uint32_t buttons = 0;
  std::int64_t time_ns = 0;
  double position[3] = {};
  double orientation[4] = {0, 0, 0, 1};
  double velocity[3] = {};
  double angular_velocity[3] = {};
};

/// Exchanges messages with the service, in two threads of its own. The first sends a force and
/// receives a state, a thousand times a second by default; it asks `take` for the force right
/// before each message. The other listens to events. A broken connection is made again after half a
/// second; each further attempt waits twice as long, up to ten seconds.
///
/// Start() and End() are for the main thread, Newest() and Allow() for the loop's, Stop() for any.
class Exchange {
 public:
  Exchange(const Place& place, Choice choice, const TandemDeviceHost& host);
  ~Exchange() { End(); }
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  void Start();
  /// Sends a last force of zero and ends both threads.
  void End();
  bool Newest(Reading& reading) const noexcept { return newest_.Read(reading); }
  std::string trouble() const { return trouble_.line(); }
  /// Asks for zero force until Allow().
  void Stop() noexcept { stopped_.store(true); }
  void Allow() noexcept { stopped_.store(false, std::memory_order_relaxed); }

 private:
  /// The content of an event, from the thread that receives events.
  struct Note {
    std::int32_t condition = TANDEM_OK;
    std::int64_t until_ns = 0;
    char line[200] = {};
  };

  void Talk();
  /// Exchanges messages as long as the connection holds. Returns whether a state came. `fault` is
  /// set where the driver closed the connection.
  bool TalkWhileConnected(std::string& fault);
  Vec3 ForceNow();
  /// Returns the device's condition by its newest state; `line` says why.
  std::int32_t ConditionOf(std::string& line);
  /// Compares the force that acts, as the service reports it, with the force that was asked for.
  void CheckForce(const Vec3& requested);
  void TurnFrom(const Quat& before, double seconds);
  void Publish(std::int32_t condition);
  void TellUnplugged(const std::string& line);
  void Listen();
  void Take(const Event& event);
  void Wait(std::int64_t ns) const;

  Place place_;
  Choice choice_;
  const TandemDeviceHost* host_;
  Seqlock<Reading> newest_;
  Seqlock<Note> note_;
  Trouble trouble_;
  std::atomic<bool> ending_{false};
  std::atomic<bool> stopped_{false};

  // used by the sending thread alone
  WebSocket socket_;
  ReportedState reported_;
  Reading reading_;
  Vec3 turning_ = Vec3::Zero();  // rad/s in V, smoothed
  int unanswered_ = 0;           // messages in a row after which no force acted
  bool ignored_ = false;         // true: the service ignores forces

  WebSocket events_;
  std::thread talker_;
  std::thread listener_;
};

}  // namespace tandem::driver::inverse3
