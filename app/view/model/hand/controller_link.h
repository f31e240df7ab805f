#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/connection/hand_request.h"
#include "collab/controller/requests.h"
#include "collab/controller/snapshot.h"
#include "engine/base/result.h"

namespace tandem {

/// A controller as the window uses it: tandem::Controller in the product, a fake in tests.
class ControllerLink {
 public:
  virtual ~ControllerLink() = default;
  virtual bool attached() const = 0;
  virtual void Send(const ControlRequest& request, OnAnswer on_answer) = 0;
  virtual void SetGoal(const PlainPose& X_WG) = 0;
  virtual const ControllerSnapshot& snapshot() const = 0;
  /// Asks the controller to end, and waits at most a second for its answer.
  virtual void Quit() = 0;
  /// Calls back for answers and takes the newest snapshot. Returns whether any message came.
  virtual bool Poll() = 0;
};

/// Attaches to this user's controller of a name; waits at most a second.
using AttachFunction =
    std::function<Result<std::unique_ptr<ControllerLink>>(const std::string& name)>;

/// A controller that this program has started. It survives a crash of this program.
class ControllerProcess {
 public:
  /// Ends the controller within a few seconds. While a signal ends this program, it waits half a
  /// second at most, and leaves a running controller to end by itself.
  virtual ~ControllerProcess() = default;
  /// Gives a controller that was asked to end the time for that, since it may have a report to
  /// write.
  virtual void AwaitEnd() {}
  /// Marks the present end of the controller's output. LinesSinceMark() returns what it said since,
  /// such as its verdicts at the end.
  virtual void MarkOutput() {}
  virtual std::vector<std::string> LinesSinceMark() { return {}; }
  /// Returns how the controller ended, in a line for a person; nothing: it runs.
  virtual std::optional<std::string> Ended() = 0;
  /// Returns the controller's newest line of output; empty: none.
  virtual std::string LastLine() = 0;
};

using LaunchFunction =
    std::function<Result<std::unique_ptr<ControllerProcess>>(const HandRequest& request)>;

}  // namespace tandem
