#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tandem {

/// What a controller of the user's own is started with.
struct HandRequest {
  std::string scene;    // file; empty: the session's, which the window looks for first
  std::string session;  // empty: one that only this machine has
  std::string name;     // of the user
  std::uint32_t domain = 42;
  std::string interface;
  std::vector<std::string> peers;
  std::string external_address;
  std::uint16_t port = 0;
  std::string secure;
  std::string control;               // name of the controller
  std::string device;                // NAME:OPTIONS, which moves the hand; empty: the mouse
  std::vector<std::string> further;  // options of `tandem peer`
};

/// The words after `tandem` that start the controller.
std::vector<std::string> PeerWords(const HandRequest& request);

}  // namespace tandem
