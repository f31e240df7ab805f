#include "app/common/program_folders.h"

#include <charconv>
#include <cstdlib>

namespace tandem {

namespace {

// Reads a variable of the environment. No part of the program sets the environment.
std::optional<std::string> Variable(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return value != nullptr ? std::optional<std::string>(value) : std::nullopt;
}

}  // namespace

std::filesystem::path ProgramFolder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

std::filesystem::path SceneFolder() {
  const std::filesystem::path above = ProgramFolder().parent_path();
  const std::filesystem::path installed = above / "share/tandem/scenes";
  std::error_code unknown;
  return std::filesystem::is_directory(installed, unknown) ? installed : above / "scenes";
}

std::filesystem::path PersonsFolder(const char* variable, const std::filesystem::path& below_home) {
  const auto named = [](const char* name) {
    return std::filesystem::path(Variable(name).value_or(""));
  };
  std::filesystem::path folder = named(variable);
  if (folder.empty() || folder.is_relative()) {
    const std::filesystem::path home = named("HOME");
    if (home.empty()) return {};
    folder = home / below_home;
  }
  return folder / "tandem";
}

std::filesystem::path CacheFolder() {
  const auto named = Variable("TANDEM_CACHE");
  return named ? std::filesystem::path(*named) : PersonsFolder("XDG_CACHE_HOME", ".cache");
}

std::optional<std::uint64_t> CacheLimit() {
  const auto text = Variable("TANDEM_CACHE_LIMIT");
  return text ? BytesOf(*text) : std::nullopt;
}

std::optional<std::uint64_t> BytesOf(const std::string& text) {
  std::uint64_t number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, fault] = std::from_chars(text.data(), end, number);
  if (fault != std::errc()) return std::nullopt;
  const std::string unit(rest, end);
  const int shift = unit.empty() ? 0 : unit == "K" ? 10 : unit == "M" ? 20 : unit == "G" ? 30 : -1;
  if (shift < 0 || number > std::uint64_t{1} << (63 - shift)) return std::nullopt;
  return number << shift;
}

}  // namespace tandem
