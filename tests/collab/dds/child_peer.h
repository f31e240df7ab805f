#pragma once

#include <chrono>
#include <string>
#include <vector>

#include <sys/types.h>

#include "collab/session/messages.h"

namespace tandem::testing {

/// A dds_test_peer in a process of its own; killed at the end if it still runs.
class ChildPeer {
 public:
  struct Options {
    Role role = Role::kActive;
    PeerId claimed = 0;           // peer whose states it publishes too; 0: only its own
    std::uint16_t port = 0;       // 0: the domain's own way of meeting; else exactly this one …
    std::uint16_t peer_port = 0;  // … and nobody but this port of this machine is called
    std::string secure = {};      // folder of keys; empty: plain
  };

  ChildPeer(const std::string& session, PeerId id, const Options& options);
  ChildPeer(const std::string& session, PeerId id) : ChildPeer(session, id, Options()) {}
  /// Starts another program that talks the same way.
  explicit ChildPeer(std::vector<std::string> command);
  ~ChildPeer();
  ChildPeer(const ChildPeer&) = delete;
  ChildPeer& operator=(const ChildPeer&) = delete;

  pid_t pid() const noexcept { return pid_; }
  void Command(const std::string& line);
  void Signal(int signal);
  /// Returns whether the child has said the line, or says it before the deadline.
  bool Says(const std::string& line, std::chrono::milliseconds deadline = std::chrono::seconds(60));
  /// Returns all that it said so far.
  const std::string& output() const { return output_; }

 private:
  pid_t pid_ = -1;
  int to_child_ = -1;
  int from_child_ = -1;
  std::string output_ = "\n";
};

}  // namespace tandem::testing
