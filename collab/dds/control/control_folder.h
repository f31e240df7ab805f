#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/base/result.h"

namespace tandem {

/// Returns the user's folder for files that this machine's controllers keep while they run. It is
/// below $XDG_RUNTIME_DIR, else below the user's cache ($XDG_CACHE_HOME, else .cache in the home
/// folder). A folder that belongs to another user is passed over. The function makes the folder if
/// it is missing. Error: the user has no such folder alone.
Result<std::filesystem::path> ControlFolder();

/// Returns the name of the folder, in ControlFolder(), for the scenes that a controller makes. The
/// controller makes it. It goes with the controller, or with the next one that starts on this
/// machine.
std::string ScenesFolderOf(const std::string& controller);

/// Returns the name of a controller's socket in ControlFolder().
std::string SocketOf(const std::string& controller);

/// Returns `readable` with 128 random bits behind it, so that nobody guesses the name.
std::string UnguessableName(const std::string& readable);

/// Returns the name of the controller that runs in that folder: `name` itself, or else the one
/// whose name UnguessableName() has made of `name`. Nothing: none, or several of these.
std::optional<std::string> FindController(const std::filesystem::path& folder,
                                          const std::string& name);

}  // namespace tandem
