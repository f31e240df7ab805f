#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "collab/controller/control_server.h"
#include "engine/base/result.h"

namespace tandem {

/// The controller's door: the topics of idl/tandem_control.idl in a DDS domain of its own, on
/// loopback. What comes in goes to a ControlServer, what that says goes out. Used by one thread,
/// but for Wake().
class ControlPort {
 public:
  struct Options {
    std::string name;  // of the controller
    std::uint32_t domain = 43;
    bool secured = false;  // makes keys for this controller and its hosts, and speaks with no
                           // program that has not read them
  };

  /// Errors: no such name, a controller of that name runs, no port is free, keys cannot be made.
  static Result<std::unique_ptr<ControlPort>> Open(const Options& options);
  virtual ~ControlPort() = default;

  /// Until something has come, or so long.
  virtual void Wait(std::int64_t at_most_ns) = 0;
  virtual void Wake() = 0;
  /// Hands on what has come.
  virtual void Take(ControlServer& server, std::int64_t now_ns) = 0;
  virtual void Say(const HostAnswer& answer) = 0;
  virtual void Say(const ControlScene& scene, bool loading) = 0;
  virtual void Say(const ControllerSnapshot& snapshot) = 0;
  /// Counts the samples of hosts that the gates have refused. Any thread calls it.
  virtual std::uint64_t refused() const noexcept = 0;
};

}  // namespace tandem
