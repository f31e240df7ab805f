#pragma once

#include "app/view/model/hand/controller_link.h"

namespace tandem {

/// Starts `tandem peer --control`, which lies beside this program, in a process group and a session
/// of its own. So the controller survives a crash of this program and the end of its terminal. Its
/// output goes to an unnamed file, since a pipe would break with this program.
Result<std::unique_ptr<ControllerProcess>> LaunchController(const HandRequest& request);

/// Attaches to a controller of this user through tandem::Controller.
Result<std::unique_ptr<ControllerLink>> AttachController(const std::string& name);

}  // namespace tandem
