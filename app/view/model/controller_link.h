#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/reach/hand_request.h"
#include "collab/controller/requests.h"
#include "collab/controller/snapshot.h"
#include "engine/base/result.h"

namespace tandem {

/// A controller as the window uses it: tandem::Controller in the product, a puppet in tests.
class ControllerLink {
 public:
  virtual ~ControllerLink() = default;
  virtual bool attached() const = 0;
  virtual void Send(const ControlRequest& request, OnAnswer on_answer) = 0;
  virtual void SetGoal(const PlainPose& X_WG) = 0;
  virtual const ControllerSnapshot& snapshot() const = 0;
  /// Asks it to end, and waits for its answer, a second at the most.
  virtual void Quit() = 0;
  /// Calls back for answers and takes the newest snapshot. Returns whether anything has come.
  virtual bool Poll() = 0;
};

/// Finds the controller of a name; waits for no longer than a second. `secured`: it has keys, and
/// no other one will do.
using AttachFunction =
    std::function<Result<std::unique_ptr<ControllerLink>>(const std::string& name, bool secured)>;

/// A controller that this program has started. It goes on when this program crashes.
class ControllerProcess {
 public:
  /// Has it end, within a few seconds; where a signal ends this program, within half a second, or
  /// in the controller's own time.
  virtual ~ControllerProcess() = default;
  /// Gives it time to end by itself, once it was asked to: it may have a report to write.
  virtual void AwaitEnd() {}
  /// How it ended, in a line for a person; nothing while it runs.
  virtual std::optional<std::string> Ended() = 0;
  /// The newest line that it has said; empty: none.
  virtual std::string LastLine() = 0;
};

using LaunchFunction =
    std::function<Result<std::unique_ptr<ControllerProcess>>(const HandRequest& request)>;

}  // namespace tandem
