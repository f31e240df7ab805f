#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace tandem::testing {

/// The devices that the fake service tells of, and how it behaves.
struct FakeWorld {
  std::string arm = "049D";             // empty: not connected
  double x = 0.01, y = 0.02, z = 0.15;  // m, in the service's frame
  double vx = 0, vy = 0, vz = 0;
  bool calibrated = true, ready = true, powered = true;
  std::string follows = "vector";  // form of forces that act
  std::string grip_kind;           // "verse_grip" or "wireless_verse_grip"; empty: no grip
  std::string grip_state = R"("orientation":{"w":1,"x":0,"y":0,"z":0})";
  std::string grip_status = R"("connected":true,"awake":true,"ready":true)";
  bool silent = false;  // answers nothing
  std::string instead;  // answer in place of a state; empty: a state
};

/// A service of the published interface: HTTP and WebSocket on one port, events on another. On
/// connecting it tells what there is; then it answers each message with one state.
class FakeService {
 public:
  /// Listens at `port`; 0: at any.
  explicit FakeService(int port = 0);
  ~FakeService();
  FakeService(const FakeService&) = delete;
  FakeService& operator=(const FakeService&) = delete;

  int port() const;
  int events_port() const;
  /// Returns options for the driver that name both ports.
  std::string ports() const;
  /// Changes the world between two messages.
  void Change(const std::function<void(FakeWorld&)>& change);
  /// Sends an event to all who listen.
  void Tell(const std::string& event);
  /// Breaks all connections of both ports. New ones are taken, unless it is `shut`.
  void Kick(bool shut = false);
  void Reopen();

  std::string first() const;  // first message of the newest connection
  std::string newest() const;
  long messages() const;
  long connections() const;
  bool Listens() const;  // somebody listens to events

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace tandem::testing
