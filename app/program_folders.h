#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace tandem {

/// Returns the folder that this program lies in, where its sister programs are.
std::filesystem::path ProgramFolder();

/// Returns Tandem's folder among those that a person has for a purpose: `tandem` of the folder that
/// an environment variable names (such as XDG_STATE_HOME), or that lies `below_home`. Empty: there
/// is no place for it.
std::filesystem::path PersonsFolder(const char* variable, const std::filesystem::path& below_home);

/// Returns the folder in which programs keep what can be made or fetched again: $TANDEM_CACHE, or
/// `tandem` of $XDG_CACHE_HOME (~/.cache). Empty: there is none, or $TANDEM_CACHE is empty, which
/// says that nothing is kept.
std::filesystem::path CacheFolder();

/// Returns how many bytes that may have: $TANDEM_CACHE_LIMIT, such as 512M or 20G. Nothing: it is
/// not set, or no such number.
std::optional<std::uint64_t> CacheLimit();

/// "512M" as bytes: a whole number, and K, M or G of 1024. Nothing for any other text.
std::optional<std::uint64_t> BytesOf(const std::string& text);

/// Returns the folder of the scenes that come with this program: `share/tandem/scenes` beside the
/// `bin` of an installation, wherever that was put or moved; the build tree's `scenes` otherwise.
std::filesystem::path SceneFolder();

}  // namespace tandem
