#include "app/connection/state_lines.h"

#include <algorithm>
#include <fstream>

#include <unistd.h>

#include "app/common/program_folders.h"

namespace tandem {

namespace {

namespace fs = std::filesystem;

/// Returns the file of a list; empty: there is no place for it.
fs::path StateFile(const std::string& list) {
  const fs::path folder = PersonsFolder("XDG_STATE_HOME", ".local/state");
  return folder.empty() ? folder : folder / list;
}

}  // namespace

std::vector<fs::path> StateLines(const std::string& list, std::size_t most) {
  std::vector<fs::path> paths;
  std::ifstream stream(StateFile(list));
  for (std::string line; paths.size() < most && std::getline(stream, line);) {
    if (!line.empty()) paths.emplace_back(line);
  }
  return paths;
}

void PutFirst(const std::string& list, const fs::path& path, std::size_t most) {
  if (path.string().find('\n') != std::string::npos) return;
  std::vector<fs::path> paths = StateLines(list, most);
  if (!paths.empty() && paths.front() == path) return;
  std::erase(paths, path);
  paths.insert(paths.begin(), path);
  paths.resize(std::min(paths.size(), most));
  const fs::path file = StateFile(list);
  if (file.empty()) return;
  std::error_code failed;
  fs::create_directories(file.parent_path(), failed);
  if (failed) return;
  // replaces the file as a whole, whichever other process writes it at the same time
  const fs::path written = file.string() + "." + std::to_string(getpid());
  std::ofstream stream(written);
  for (const fs::path& one : paths) stream << one.string() << '\n';
  if (stream.flush()) {
    fs::rename(written, file, failed);
  } else {
    fs::remove(written, failed);
  }
}

}  // namespace tandem
