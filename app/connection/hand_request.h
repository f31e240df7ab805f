#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tandem {

/// The options that a user's own controller is started with.
struct HandRequest {
  std::string scene;    // scene's file; empty: the session's scene, which the window looks for
                        // first
  std::string session;  // session's name; empty: a session on this machine alone
  std::string name;     // user's name
  std::uint32_t domain = 42;
  std::string interface;
  std::vector<std::string> peers;
  std::string external_address;
  std::uint16_t port = 0;
  std::string secure;
  std::string control;               // controller's name
  std::string device;                // NAME:OPTIONS of the device that moves the hand; empty: the
                                     // mouse
  std::vector<std::string> further;  // further options of `tandem peer`
};

/// Returns the words after `tandem` that start the controller.
std::vector<std::string> ControllerCommandLine(const HandRequest& request);

}  // namespace tandem
