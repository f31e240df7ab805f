#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "collab/controller/control_server.h"
#include "collab/controller/controller.h"
#include "collab/dds/control/control_socket.h"
#include "collab/dds/wire/control_wire.h"
#include "engine/realtime/clock.h"

namespace tandem {

/// The host's end of the command interface. It has two threads: the host's, and one of ours that
/// connects, receives and shows that the process lives.
class Controller::Link {
 public:
  /// `folder`: where controllers have their sockets.
  Link(std::string name, const Options& options, std::filesystem::path folder);
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// Waits for at most a tenth of a second until the controller has been heard.
  bool Meet();
  /// Returns a request with the next number and this host's name, to be filled in.
  tandem_control_Request NextRequest();
  /// Repeats a first request, by which the controller knows this host's name, until it is answered
  /// or that time has come.
  void Introduce(std::int64_t until_ns);
  /// Returns what is wrong with the version of the controller that was heard.
  std::optional<Error> VersionFault() const;
  /// Returns why the last try to connect failed.
  std::string WhyNotConnected() const {
    const std::lock_guard lock(mutex_);
    return why_;
  }

  bool attached() const {
    const std::lock_guard lock(mutex_);
    return Heard();
  }
  void Send(const ControlRequest& request, OnAnswer on_answer);
  void SetGoal(HostGoal::Kind kind, const Pose& X_WG, const Vec3& linear, const Vec3& angular);
  void OnSnapshot(std::function<void(const ControllerSnapshot&)> callback) {
    on_snapshot_ = std::move(callback);
  }
  const ControllerSnapshot& snapshot() const { return snapshot_; }
  bool Poll();
  void WaitForSomething(std::chrono::milliseconds at_most) {
    std::unique_lock lock(mutex_);
    something_.wait_for(lock, at_most, [this] {
      return Fresh();
    });
  }

 private:
  static constexpr std::int64_t kGoneNs = 500'000'000;  // time without a snapshot

  /// A copy of a message that owns its lists, in the form that FromWire reads.
  struct SceneCopy {
    tandem_control_Scene wire{};
    std::vector<tandem_control_SceneBody> bodies;

    void Keep(const tandem_control_Scene& message) {
      wire = message;
      bodies.assign(message.bodies._buffer, message.bodies._buffer + message.bodies._length);
      wire.bodies._buffer = bodies.data();
    }
  };
  bool Fresh() const { return fresh_ || !answers_.empty(); }
  bool Heard() const { return received_ns_ != 0 && MonotonicNowNs() - received_ns_ < kGoneNs; }
  using Outcome = ControlConnection::Outcome;
  void Run();
  void Connect();
  /// Waits for the controller, for Wake() or for so long.
  void WaitForInput(std::int64_t at_most_ns) const;
  void Wake() const;
  void Receive();
  /// Keeps what came in a packet; the caller has the lock. True: the host's thread has to look.
  bool Take(std::span<char> packet);
  bool Take(const tandem_control_Snapshot& wire);
  Outcome Send(const std::vector<char>& packet);
  /// Sends a message that must arrive; waits for room a moment.
  bool Deliver(const tandem_control_Request& wire);
  void Beat(bool goodbye);
  void AnswerForTheGone();

  const std::string name_;
  const std::string host_name_;
  const std::filesystem::path folder_;
  std::uint64_t id_ = 0;
  OwnDescriptor wake_;

  // used by our thread
  std::vector<char> packet_;
  std::int64_t next_try_ns_ = 0;

  // used by the host's thread
  std::uint64_t next_number_ = 1;
  std::map<std::uint64_t, OnAnswer> waiting_;  // callbacks of unanswered requests, by number
  std::function<void(const ControllerSnapshot&)> on_snapshot_;
  ControllerSnapshot snapshot_;
  std::int64_t gone_since_ns_ = 0;

  // used by both threads
  mutable std::mutex mutex_;
  std::condition_variable something_;
  std::optional<ControlConnection> connection_;  // changed by our thread alone
  std::string why_;  // why the last try to connect failed; empty: it did not
  bool stopping_ = false;
  HostGoal goal_;            // newest goal
  bool goal_waits_ = false;  // it is to be sent as soon as there is time
  std::int64_t last_goal_ns_ = 0;
  std::uint64_t controller_ = 0;  // id of the controller that was heard
  std::uint64_t last_sent_ = 0;   // number of the newest request that was sent
  std::uint64_t lost_to_ = 0;  // requests up to this number went over a connection that has ended
  double rate_hz_ = 60;        // rate of snapshots that this host has asked for
  std::int64_t next_snapshot_ns_ = 0;
  SceneCopy scene_;
  std::uint32_t other_version_ = 0;
  bool fresh_ = false;
  ControllerSnapshot newest_;
  std::deque<HostAnswer> answers_;
  std::int64_t received_ns_ = 0;

  std::thread thread_;
};

}  // namespace tandem
