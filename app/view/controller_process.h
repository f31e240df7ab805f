#pragma once

#include "app/view/model/controller_link.h"

namespace tandem {

/// Starts `tandem peer --control`, which lies beside this program, in a process group and a session
/// of its own: neither a crash of this program nor the end of its terminal takes it along. What it
/// says goes to a file without a name, for a pipe would break with this program.
Result<std::unique_ptr<ControllerProcess>> LaunchController(const HandRequest& request);

/// Finds a controller by tandem::Controller. `secured`: it has keys, and no other one will do.
Result<std::unique_ptr<ControllerLink>> AttachController(const std::string& name, bool secured);

}  // namespace tandem
