#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/connection/connection_options.h"
#include "app/view/model/hand/controller_link.h"
#include "app/view/model/session/session_model.h"

namespace tandem {

/// The options of `tandem-view`.
struct ViewOptions {
  JoinRequest join;  // session empty: the form waits for one
  ConnectionOptions connection;
  std::string scene;
  std::string open;        // scene to open with a hand; empty: none
  bool take_part = false;  // true: take part in the session, with a hand
  bool attach = false;     // true: attach to a running controller
  bool own = false;        // true: the attached controller ends with the window
  std::string peer_options;
  HandRequest hand;        // request for taking part
  bool proximity = false;  // true: proximity is shown from the start
  bool blind = false;      // true: hide all that reveals the network's condition
  bool fit = false;        // true: fit the camera to the bodies' poses before the picture
  std::string screenshot;
  double screenshot_after = 1;  // s after the picture is complete
  std::string paint;            // file of pictures to paint, without a window
  std::string paint_into;       // folder for them
  std::string time_pictures;    // file for the times of a scene's pictures, without a window
  int check_display = -1;       // descriptor for what a window finds here; below 0: none
  int rounds = 5;               // rounds of these times
  std::string report;
  double seconds = 0;  // s until the program ends; 0: until the window is closed
};

/// Reads the command line. Without a value the program ends with `exit_code`: help was printed, or
/// one line on stderr says what is wrong.
std::optional<ViewOptions> ReadOptions(int argc, char** argv, int& exit_code);

/// Returns why there is no display for a window; empty: none is known. Qt itself ends the program
/// where it finds no display.
std::string DisplayTrouble();

}  // namespace tandem
