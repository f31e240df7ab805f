#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/process/child_processes.h"
#include "collab/coupling/coupling_law.h"

namespace tandem::testing {

/// Peers of the product, each a process of its own, that hold the peg of peg_in_slot together over
/// loopback.
class RealPeers {
 public:
  struct Options {
    int count = 2;         // they wait for one another
    double seconds = 4;    // duration of the hands' motion
    std::string output{};  // a file for what they say; empty: to our own stderr
    std::string law = DefaultLaw()->name();
  };

  explicit RealPeers(const Options& options);

  const std::string& session() const noexcept { return session_; }
  ChildProcess& peer(std::size_t i) { return peers_[i]; }
  /// Waits for all, and returns their exit codes; -1 for one that did not end in time.
  std::vector<int> Wait();
  /// Returns what a peer reported at the end; not an object where it did not.
  nlohmann::json Report(std::size_t i) const;

 private:
  std::filesystem::path ReportFile(std::size_t i) const;

  TemporaryFolder folder_;
  std::string session_;
  std::vector<ChildProcess> peers_;
};

}  // namespace tandem::testing
