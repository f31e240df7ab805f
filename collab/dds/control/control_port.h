#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "collab/controller/control_server.h"
#include "engine/base/result.h"

namespace tandem {

/// The controller's end of the command interface: the messages of idl/tandem_control.idl over a
/// local socket in ControlFolder(). Programs of the controller's own user alone can connect. The
/// port hands incoming messages to a ControlServer and sends the server's answers. One thread uses
/// it, except Wake() and refused().
class ControlPort {
 public:
  /// Opens the port of a controller of that name. Errors: the name is invalid, a controller of that
  /// name runs, or the user has no folder of its own.
  static Result<std::unique_ptr<ControlPort>> Open(const std::string& name);
  virtual ~ControlPort() = default;

  /// Waits until a message comes or Wake() is called, at most so long.
  virtual void Wait(std::int64_t at_most_ns) = 0;
  virtual void Wake() = 0;
  /// Hands incoming messages to the server.
  virtual void Take(ControlServer& server, std::int64_t now_ns) = 0;
  virtual void Say(const HostAnswer& answer) = 0;
  virtual void Say(const ControlScene& scene, bool loading) = 0;
  virtual void Say(const ControllerSnapshot& snapshot) = 0;
  /// Counts what the port has refused: programs of other users, damaged messages, messages in
  /// another host's name, and messages beyond the pace. Any thread may call it.
  virtual std::uint64_t refused() const noexcept = 0;
};

}  // namespace tandem
