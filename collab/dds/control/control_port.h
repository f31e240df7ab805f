#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "collab/controller/control_server.h"
#include "engine/base/result.h"

namespace tandem {

/// The controller's end of the command interface: the topics of idl/tandem_control.idl in a
/// separate DDS domain on loopback. It hands incoming samples to a ControlServer and sends the
/// server's answers. One thread uses it, except Wake() and refused().
class ControlPort {
 public:
  struct Options {
    std::string name;  // name of the controller
    std::uint32_t domain = 43;
    bool secured = false;  // makes keys for this controller and its hosts, and refuses programs
                           // without them
  };

  /// Errors: the name is invalid, a controller of that name runs, no port is free, or keys cannot
  /// be made.
  static Result<std::unique_ptr<ControlPort>> Open(const Options& options);
  virtual ~ControlPort() = default;

  /// Waits until a sample comes or Wake() is called, at most so long.
  virtual void Wait(std::int64_t at_most_ns) = 0;
  virtual void Wake() = 0;
  /// Hands incoming samples to the server.
  virtual void Take(ControlServer& server, std::int64_t now_ns) = 0;
  virtual void Say(const HostAnswer& answer) = 0;
  virtual void Say(const ControlScene& scene, bool loading) = 0;
  virtual void Say(const ControllerSnapshot& snapshot) = 0;
  /// Counts the samples of hosts that the gates have refused. Any thread may call it.
  virtual std::uint64_t refused() const noexcept = 0;
};

}  // namespace tandem
