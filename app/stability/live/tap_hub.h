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

#include "collab/receive/link_conditioner.h"
#include "engine/base/result.h"

namespace tandem {

/// A network of real packets on this machine, for programs that are to run as if on several
/// machines. Each port has a network namespace. A hub in this process holds every Ethernet frame
/// between them back, or loses it, as a link conditioner says. So all of a session is late, its
/// discovery and its answers too. Needs root, Linux and the command `ip`. The network is gone with
/// this object.
class TapHub {
 public:
  /// The network card that programs see at their port: 10.78.0.1, 10.78.0.2 ...
  static constexpr const char* kInterface = "tandem0";

  /// A function that gives the conditions for frames from one port to another.
  using Conditions = std::function<LinkConditions(std::size_t from, std::size_t to)>;

  /// Makes the network. Errors say what is missing.
  static Result<std::unique_ptr<TapHub>> Open(std::size_t ports, const Conditions& conditions);
  ~TapHub();
  TapHub(const TapHub&) = delete;
  TapHub& operator=(const TapHub&) = delete;

  /// Sets other conditions for frames from one port to another, such as those of a pulled cable.
  /// Frames under way arrive. From any thread.
  void Switch(std::size_t from, std::size_t to, const LinkConditions& conditions);

  /// Returns the words that start the command at that port.
  std::vector<std::string> At(std::size_t port, std::vector<std::string> command) const;
  /// Returns the number of frames carried so far, or lost: by the conditions or at a port whose
  /// queue is full.
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
  std::mutex mutex_;                    // guards links_
  std::vector<LinkConditioner> links_;  // index is from * ports + to
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> carried_{0};
  std::atomic<std::uint64_t> lost_{0};
  std::thread thread_;
};

}  // namespace tandem
