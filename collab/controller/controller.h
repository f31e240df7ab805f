#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "collab/controller/requests.h"
#include "collab/controller/snapshot.h"
#include "engine/base/result.h"

namespace tandem {

/// The way a host application speaks to a controller, the process `tandem peer --control NAME` that
/// owns simulation, voxels, session and device (paper §6; docs/controller.md). It needs tandem::dds
/// to link; this header and its two neighbours have neither Eigen nor DDS in them.
///
/// What must not be lost is a request with an answer: Send(), Ask(). What carries the hand is a
/// stream of which the newest counts: SetGoal(), SetRate(), SetPush(), snapshots. The controller
/// depends on no host: one that falls silent for 0.5 s has let go of what its hand held, and it or
/// another may attach at any time and finds all as it is.
///
/// Used by one thread. The library has a thread of its own, which shows the controller every 50 ms
/// that this process lives: a host may be busy for as long as it likes between two calls. Callbacks
/// come from within Poll(), Wait() and Ask(), in the thread that calls these.
class Controller {
 public:
  struct Options {
    std::string host = "host";  // what the controller's messages call this program
    std::uint32_t domain = 43;  // DDS domain of control; that of the session is another
    double timeout_s = 2;       // to find the controller
    std::string keys;           // folder of the host's keys; empty: where the controller of that
                                // name has put them, if it is secured
    bool secured = false;       // the controller has keys: waits for them, and never speaks plainly
  };

  /// Finds the controller of that name on this machine. Errors: there is none, it speaks another
  /// version, its keys cannot be read.
  static Result<Controller> Attach(const std::string& name, const Options& options);
  static Result<Controller> Attach(const std::string& name) { return Attach(name, Options()); }

  Controller(Controller&&) noexcept;
  Controller& operator=(Controller&&) noexcept;
  /// Says goodbye: what this host holds is let go of at once.
  ~Controller();

  /// Whether the controller was heard within the last 0.5 s. It becomes true again by itself when
  /// the controller, or a new one of that name, is there.
  bool attached() const;

  /// Asks, and calls `on_answer` from a later Poll(). A controller that is gone answers by the
  /// library: not ok, "the controller NAME is gone". More than 32 that wait are refused; an emergency
  /// stop never is.
  void Send(const ControlRequest& request, OnAnswer on_answer = {});
  /// Asks and waits, calling other callbacks meanwhile. Not from within a callback.
  Answer Ask(const ControlRequest& request, double timeout_s = 60);

  /// Where the grasp frame is to be (GrabRequest). Counts while this host's hand holds something or
  /// has asked for it; otherwise it is ignored. At most 1000 a second are taken.
  void SetGoal(const PlainPose& X_WG);
  /// The goal moves on at this velocity, until another call says otherwise or 0.2 s went by.
  void SetRate(const std::array<double, 3>& v_W, const std::array<double, 3>& w_W);
  /// A push by a device that measures force: the goal moves on at a velocity in proportion to it.
  /// Lasts as SetRate() does.
  void SetPush(const std::array<double, 3>& force_N, const std::array<double, 3>& torque_Nm);

  /// Called with each new snapshot that Poll() finds; those that came in between are skipped.
  void OnSnapshot(std::function<void(const ControllerSnapshot&)> callback);
  /// The newest snapshot that Poll() has found. Attach() waits for the first.
  const ControllerSnapshot& snapshot() const;

  /// Calls back for answers and the newest snapshot that have come. Returns whether there was any.
  bool Poll();
  /// The same, and waits for that long if nothing has come.
  bool Wait(std::chrono::milliseconds at_most);

 private:
  class Link;
  explicit Controller(std::unique_ptr<Link> link);
  std::unique_ptr<Link> link_;
};

}  // namespace tandem
