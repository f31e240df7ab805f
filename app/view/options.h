#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/reach/reach_options.h"
#include "app/view/model/controller_link.h"
#include "app/view/model/session_model.h"

namespace tandem {

/// What `tandem-view` was asked for.
struct ViewOptions {
  JoinRequest join;  // session empty: the form waits
  ReachOptions reach;
  std::string scene;
  std::string open;        // scene to take part in; empty: none
  bool take_part = false;  // in the session, with a hand
  bool attach = false;     // to a controller that runs already
  bool own = false;        // which ends with the window
  std::string peer_options;
  HandRequest hand;        // by which one takes part
  bool proximity = false;  // shown from the start
  bool blind = false;      // nothing is shown that tells of the network
  bool fit = false;        // to the bodies where they are, before a picture is taken
  std::string screenshot;
  double screenshot_after = 1;  // s from when the picture is complete
  std::string paint;            // pictures to paint: no window then
  std::string paint_into;       // folder for them
  std::string time_pictures;    // file for the times of a scene's pictures: no window then
  int rounds = 5;               // of these times
  std::string report;
  double seconds = 0;  // then end; 0: until the window is closed
};

/// Reads the command line. Without a value the program is to end with `exit_code`: help was
/// printed, or what is wrong (one line on stderr).
std::optional<ViewOptions> ReadOptions(int argc, char** argv, int& exit_code);

/// Why there is no display to open a window on; empty when there is one, as far as one can tell
/// before Qt tries (and ends the program when it fails).
std::string DisplayTrouble();

}  // namespace tandem
