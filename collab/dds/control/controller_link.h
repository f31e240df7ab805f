#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "collab/controller/control_server.h"
#include "collab/controller/controller.h"
#include "collab/dds/control/control_domain.h"
#include "collab/dds/transport/fast_reader.h"
#include "collab/dds/wire/control_wire.h"

namespace tandem {

/// The host's end of the command interface. It has two threads: the host's, and one of ours that
/// receives and shows that the process lives.
class Controller::Link {
 public:
  Link(std::string name, const Options& options, ControlDomain domain)
      : name_(std::move(name)), host_name_(options.host), domain_(std::move(domain)) {
    std::random_device random;
    while (id_ == 0) id_ = std::uint64_t{random()} << 32U | random();
  }
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  bool Open();
  /// Waits for at most a tenth of a second until the controller has been heard.
  bool Meet();
  /// Returns a request with the next number and this host's name, to be filled in.
  tandem_control_Request NextRequest();
  /// Repeats a first request, by which the controller knows this host's name, until it is answered
  /// or that time has come. While a controller is flooded it may drop the samples of an unknown
  /// host.
  void Introduce(std::int64_t until_ns);
  /// Returns what is wrong with the version of the controller that was heard.
  std::optional<Error> VersionFault() const;

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

  /// A copy of a sample that owns its lists, in the form that FromWire reads.
  struct SceneCopy {
    tandem_control_Scene wire{};
    std::vector<tandem_control_SceneBody> bodies;

    void Keep(const tandem_control_Scene& sample) {
      wire = sample;
      bodies.assign(sample.bodies._buffer, sample.bodies._buffer + sample.bodies._length);
      wire.bodies._buffer = bodies.data();
    }
  };
  bool Fresh() const { return fresh_ || !answers_.empty(); }
  bool Heard() const { return received_ns_ != 0 && MonotonicNow_ns() - received_ns_ < kGoneNs; }
  void Run();
  void Receive();
  void Beat(bool goodbye);
  void AnswerForTheGone();

  const std::string name_;
  const std::string host_name_;
  ControlDomain domain_;
  std::uint64_t id_ = 0;
  dds_entity_t requests_ = 0;
  dds_entity_t goals_ = 0;
  dds_entity_t answers_reader_ = 0;
  dds_entity_t scenes_ = 0;
  dds_entity_t snapshots_ = 0;
  dds_entity_t wake_ = 0;
  dds_entity_t waitset_ = 0;

  // used by the host's thread
  std::uint64_t next_number_ = 1;
  std::map<std::uint64_t, OnAnswer> waiting_;  // callbacks of unanswered requests, by number
  std::function<void(const ControllerSnapshot&)> on_snapshot_;
  ControllerSnapshot snapshot_;
  std::int64_t gone_since_ns_ = 0;

  // used by both threads
  mutable std::mutex mutex_;
  std::condition_variable something_;
  bool stopping_ = false;
  HostGoal goal_;            // newest goal
  bool goal_waits_ = false;  // it is to be sent as soon as there is time
  std::int64_t last_goal_ns_ = 0;
  std::uint64_t controller_ = 0;  // id of the controller that was heard
  bool replaced_ = false;         // another controller has taken its name
  double rate_hz_ = 60;           // rate of snapshots that this host has asked for
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
