#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "collab/link_conditioner.h"
#include "engine/base/result.h"

namespace tandem {

/// A network of real packets on this machine, for programs that are to be as if on several: a
/// network namespace for each port and, between them, a hub in this process that holds every frame
/// of Ethernet back, or loses it, as a link conditioner says. So all of a session is late, its
/// discovery and its answers too. Needs root, Linux and the command `ip`; gone with this object.
class TapHub {
 public:
  /// The network card that programs see at their port: 10.78.0.1, 10.78.0.2 ...
  static constexpr const char* kInterface = "tandem0";

  /// What happens to that which one port sends to another.
  using Conditions = std::function<LinkConditions(std::size_t from, std::size_t to)>;

  /// Errors say what is missing.
  static Result<std::unique_ptr<TapHub>> Open(std::size_t ports, const Conditions& conditions);
  ~TapHub();
  TapHub(const TapHub&) = delete;
  TapHub& operator=(const TapHub&) = delete;

  /// Other conditions from now on for what one port sends to another: a cable that is pulled. What
  /// is under way arrives. From any thread.
  void Switch(std::size_t from, std::size_t to, const LinkConditions& conditions);

  /// The command as it is to be started to run at that port.
  std::vector<std::string> At(std::size_t port, std::vector<std::string> command) const;
  /// Frames carried so far, and lost by the conditions.
  std::uint64_t carried() const noexcept { return carried_.load(); }
  std::uint64_t lost() const noexcept { return lost_.load(); }

 private:
  struct Port {
    std::string space;  // network namespace
    int descriptor = -1;
  };

  TapHub() = default;
  std::optional<Error> AddPort();
  void Run();

  std::vector<Port> ports_;
  std::mutex mutex_;                    // of links_
  std::vector<LinkConditioner> links_;  // from * ports + to
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> carried_{0};
  std::atomic<std::uint64_t> lost_{0};
  std::thread thread_;
};

}  // namespace tandem
