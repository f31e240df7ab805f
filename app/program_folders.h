#pragma once

#include <filesystem>

namespace tandem {

/// Returns the folder that this program lies in, where its sister programs are.
std::filesystem::path ProgramFolder();

/// Returns Tandem's folder among those that a person has for a purpose: `tandem` of the folder that
/// an environment variable names (such as XDG_STATE_HOME), or that lies `below_home`. Empty: there
/// is no place for it.
std::filesystem::path PersonsFolder(const char* variable, const std::filesystem::path& below_home);

/// Returns the folder of the scenes that come with this program: `share/tandem/scenes` beside the
/// `bin` of an installation, wherever that was put or moved; the build tree's `scenes` otherwise.
std::filesystem::path SceneFolder();

}  // namespace tandem
