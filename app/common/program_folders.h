#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace tandem {

/// Returns the folder of this program's executable, which also holds the other programs.
std::filesystem::path ProgramFolder();

/// Returns Tandem's folder for one kind of a person's files: `tandem` in the folder that the
/// environment `variable` names (such as XDG_STATE_HOME), else in `below_home` of $HOME. Empty:
/// neither is set.
std::filesystem::path PersonsFolder(const char* variable, const std::filesystem::path& below_home);

/// Returns the folder of data that programs can make or fetch again: $TANDEM_CACHE, else `tandem`
/// in $XDG_CACHE_HOME (~/.cache). Empty: nothing is kept, since there is no such folder or
/// $TANDEM_CACHE is empty.
std::filesystem::path CacheFolder();

/// Returns the cache's largest size in bytes: $TANDEM_CACHE_LIMIT, such as 512M or 20G. Nothing: it
/// is not set or invalid.
std::optional<std::uint64_t> CacheLimit();

/// Returns a text such as "512M" as bytes: a whole number, with K, M or G of 1024 or without a
/// unit. Nothing: the text has another form.
std::optional<std::uint64_t> BytesOf(const std::string& text);

/// Returns the folder of the scenes that come with this program: `share/tandem/scenes` beside the
/// `bin` of an installation, wherever it lies; else the build tree's `scenes`.
std::filesystem::path SceneFolder();

}  // namespace tandem
