#include "tests/architecture/tree_files.h"

#include <algorithm>
#include <fstream>
#include <sstream>

namespace tandem::testing {

namespace fs = std::filesystem;

std::vector<fs::path> TreeFiles() {
  const fs::path top = TANDEM_SOURCE_DIR;
  std::vector<fs::path> files;
  for (auto it = fs::recursive_directory_iterator(top); it != fs::recursive_directory_iterator();
       ++it) {
    const std::string name = it->path().filename();
    const bool is_built = it.depth() == 0 && name.starts_with("build");
    if (it->is_directory() && (is_built || name.starts_with('.'))) {
      it.disable_recursion_pending();
    }
    if (it->is_regular_file()) files.push_back(fs::relative(it->path(), top));
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string TreeText(const fs::path& from_top) {
  std::ostringstream text;
  text << std::ifstream(fs::path(TANDEM_SOURCE_DIR) / from_top).rdbuf();
  return text.str();
}

}  // namespace tandem::testing
