#include "collab/dds/control/control_folder.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <system_error>
#include <vector>

#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tandem {

namespace {

namespace fs = std::filesystem;

constexpr const char* kSocketEnding = ".sock";
constexpr std::size_t kRandomDigits = 32;  // hexadecimal digits

// Returns an absolute path of the environment; empty: there is none.
fs::path PathFrom(const char* variable) {
  // no code of ours sets the environment
  const char* value = std::getenv(variable);  // NOLINT(concurrency-mt-unsafe)
  return value != nullptr && *value == '/' ? fs::path(value) : fs::path();
}

// Returns the home folder of the user's account; empty: the account has none.
fs::path AccountsHome() {
  std::array<char, 4096> text{};
  passwd account{};
  passwd* found = nullptr;
  getpwuid_r(geteuid(), &account, text.data(), text.size(), &found);
  return found != nullptr && *found->pw_dir == '/' ? fs::path(found->pw_dir) : fs::path();
}

bool IsOwnFolder(const fs::path& folder) {
  struct stat facts {};
  return stat(folder.c_str(), &facts) == 0 && S_ISDIR(facts.st_mode) && facts.st_uid == geteuid();
}

// Returns the folder below `own`, made where it is missing; nothing: that cannot be.
std::optional<fs::path> MadeBelow(const fs::path& own, const std::vector<const char*>& names) {
  fs::path folder = own;
  for (const char* name : names) {
    folder /= name;
    if (mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) return std::nullopt;
    if (!IsOwnFolder(folder)) return std::nullopt;
  }
  return folder;
}

}  // namespace

Result<fs::path> ControlFolder() {
  struct Place {
    fs::path own;  // a folder that is the user's already
    std::vector<const char*> below;
  };
  const std::array<Place, 4> places{{{PathFrom("XDG_RUNTIME_DIR"), {"tandem"}},
                                     {PathFrom("XDG_CACHE_HOME"), {"tandem", "run"}},
                                     {PathFrom("HOME"), {".cache", "tandem", "run"}},
                                     {AccountsHome(), {".cache", "tandem", "run"}}}};
  for (const Place& place : places) {
    if (place.own.empty() || !IsOwnFolder(place.own)) continue;
    const std::optional<fs::path> folder = MadeBelow(place.own, place.below);
    if (!folder) continue;
    struct stat facts {};
    if (lstat(folder->c_str(), &facts) != 0 || !S_ISDIR(facts.st_mode)) continue;
    if ((facts.st_mode & 0077) == 0) return *folder;
    return Error{folder->string() + " is open to other users, and controllers keep their files " +
                 "there: chmod 700 " + folder->string()};
  }
  return Error{
      "no folder of yours alone for controllers: set XDG_RUNTIME_DIR to a folder that you own "
      "(mode 700)"};
}

std::string ScenesFolderOf(const std::string& controller) {
  return controller + ".scenes";
}

std::string SocketOf(const std::string& controller) {
  return controller + kSocketEnding;
}

std::string UnguessableName(const std::string& readable) {
  std::random_device random;
  std::string name = readable + "-";
  for (std::size_t digit = 0; digit < kRandomDigits; digit += 8) {
    std::array<char, 9> text{};
    std::snprintf(text.data(), text.size(), "%08x", static_cast<unsigned>(random()));
    name += text.data();
  }
  return name;
}

std::optional<std::string> FindController(const fs::path& folder, const std::string& name) {
  std::error_code unknown;
  if (fs::exists(fs::symlink_status(folder / SocketOf(name), unknown))) return name;
  std::optional<std::string> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, unknown)) {
    const std::string other = entry.path().stem().string();
    const bool is_made_of_it =
        entry.path().extension() == kSocketEnding && other.starts_with(name + "-") &&
        other.size() == name.size() + 1 + kRandomDigits &&
        other.find_first_not_of("0123456789abcdef", name.size() + 1) == std::string::npos;
    if (!is_made_of_it) continue;
    if (found) return std::nullopt;
    found = other;
  }
  return found;
}

}  // namespace tandem
