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

/// Where the service is, and how often it is asked.
struct Place {
  int port = 10001;
  int events_port = 10020;  // 0: events are not listened to
  double rate_hz = 1000;
};

/// The newest that is known of the handle.
struct Reading {
  std::uint64_t number = 0;  // of the message
  std::int32_t condition = TANDEM_UNPLUGGED;
  std::uint32_t buttons = 0;
  std::int64_t time_ns = 0;
  double position[3] = {};
  double orientation[4] = {0, 0, 0, 1};
  double velocity[3] = {};
  double angular_velocity[3] = {};
};

/// The conversation with the service, in two threads of its own. One sends a force and receives a
/// state, a thousand times a second; it asks `take` for the force, right before each message. The
/// other listens to events. A connection that breaks is made again, after half a second, then after
/// twice as long each time, up to ten seconds.
///
/// Start() and End() are for the main thread, Newest() and Allow() for the loop's, Stop() for any.
class Exchange {
 public:
  Exchange(const Place& place, Choice choice, const TandemDeviceHost& host);
  ~Exchange() { End(); }
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  void Start();
  /// Asks for no force a last time, and ends both threads.
  void End();
  bool Newest(Reading& reading) const noexcept { return newest_.Read(reading); }
  std::string trouble() const { return trouble_.line(); }
  /// No force from now on, until Allow().
  void Stop() noexcept { stopped_.store(true); }
  void Allow() noexcept { stopped_.store(false, std::memory_order_relaxed); }

 private:
  /// What events say, from the thread that hears them.
  struct Note {
    std::int32_t condition = TANDEM_OK;
    std::int64_t until_ns = 0;
    char line[200] = {};
  };

  void Talk();
  /// Exchanges messages as long as the connection holds. Whether a state came. `fault` says why it
  /// was closed from here.
  bool TalkWhileConnected(std::string& fault);
  Vec3 ForceNow();
  /// What a state makes of the device's condition; `line`: why.
  std::int32_t ConditionOf(std::string& line);
  /// Compares the force that acts, by the service's word, with what it was asked for.
  void CheckForce(const Vec3& asked);
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

  // the talking thread's
  WebSocket socket_;
  Told told_;
  Reading reading_;
  Vec3 turning_ = Vec3::Zero();  // rad/s in V, smoothed
  int unanswered_ = 0;           // messages in turn after which no force acted
  bool ignored_ = false;         // the service does not follow

  WebSocket events_;
  std::thread talker_;
  std::thread listener_;
};

}  // namespace tandem::driver::inverse3
