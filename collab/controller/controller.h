#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "collab/controller/requests.h"
#include "collab/controller/snapshot.h"
#include "engine/base/result.h"

namespace tandem {

/// Connects a host application to a controller, the process `tandem peer --control NAME` that owns
/// simulation, voxels, session and device (paper §6; docs/controller.md). It needs tandem::dds to
/// link; this header and its two neighbours use neither Eigen nor DDS.
///
/// Requests must not be lost and have an answer: Send(), Ask(). Goals and snapshots are streams in
/// which the newest counts: SetGoal(), SetRate(), SetPush(), snapshots. The controller depends on
/// no host. A host that falls silent for 0.5 s lets go of its part. It or another host may attach
/// at any time and finds everything in its present state.
///
/// Used by one thread. The library has its own thread, which shows the controller every 50 ms that
/// this process lives: a host may be busy between two calls for any time. Poll(), Wait() and Ask()
/// call the callbacks, in their caller's thread.
class Controller {
 public:
  struct Options {
    std::string host = "host";  // name of this program in the controller's messages
    double timeout_s = 2;       // time to find the controller
    // Without effect: every controller answers the programs of its own user alone.
    std::uint32_t domain = 43;
    std::string keys;
    bool secured = false;
  };

  /// Finds this user's controller of that name on this machine. Errors: there is none, another user
  /// owns it, or it has another version. A window's controller is called window-PID-DIGITS, and
  /// "window-PID" finds it.
  static Result<Controller> Attach(const std::string& name, const Options& options);
  static Result<Controller> Attach(const std::string& name) { return Attach(name, Options()); }

  Controller(Controller&&) noexcept;
  Controller& operator=(Controller&&) noexcept;
  /// Says goodbye: the host's hand lets go at once.
  ~Controller();

  /// Returns whether the controller was heard within the last 0.5 s. It becomes true again by
  /// itself when the controller, or a new one of that name, is there.
  bool attached() const;

  /// Sends a request; a later Poll() calls `on_answer`. For a controller that is gone the library
  /// answers: not ok, "the controller NAME is gone". Beyond 32 waiting requests a further one is
  /// refused, except an emergency stop.
  void Send(const ControlRequest& request, OnAnswer on_answer = {});
  /// Sends a request and waits, calling other callbacks meanwhile. Not from within a callback.
  Answer Ask(const ControlRequest& request, double timeout_s = 60);

  /// Sets the goal of the grasp frame (GrabRequest). Counts while this host's hand holds a part or
  /// has asked for one; otherwise it is ignored. At most 1000 a second are taken.
  void SetGoal(const PlainPose& X_WG);
  /// Moves the goal on at this velocity, until another call or for 0.2 s.
  void SetRate(const std::array<double, 3>& v_W, const std::array<double, 3>& w_W);
  /// Pushes by a device that measures force: the goal moves on at a velocity in proportion to the
  /// force. Lasts as long as SetRate() does.
  void SetPush(const std::array<double, 3>& force_N, const std::array<double, 3>& torque_Nm);

  /// Sets a callback for each new snapshot that Poll() finds; it skips those that came in between.
  void OnSnapshot(std::function<void(const ControllerSnapshot&)> callback);
  /// The newest snapshot that Poll() has found. Attach() waits for the first.
  const ControllerSnapshot& snapshot() const;

  /// Calls back for answers and for the newest snapshot. Returns whether there was any.
  bool Poll();
  /// Does the same, and waits for that long if nothing has come.
  bool Wait(std::chrono::milliseconds at_most);

 private:
  class Link;
  explicit Controller(std::unique_ptr<Link> link);
  std::unique_ptr<Link> link_;
};

}  // namespace tandem
