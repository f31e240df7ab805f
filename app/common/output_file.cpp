#include "app/common/output_file.h"

#include <cerrno>
#include <cstring>

#include <unistd.h>

namespace tandem {

std::string WhyNotWritable(const std::filesystem::path& file) {
  std::error_code not_there;
  int fault = 0;
  if (std::filesystem::is_directory(file, not_there)) {
    fault = EISDIR;
  } else if (std::filesystem::exists(file, not_there)) {
    fault = access(file.c_str(), W_OK) == 0 ? 0 : errno;
  } else {
    // creates no file as a test: two programs that ask at once would remove each other's file
    const std::filesystem::path folder = file.parent_path();
    fault = access(folder.empty() ? "." : folder.c_str(), W_OK | X_OK) == 0 ? 0 : errno;
  }
  if (fault == 0) return {};
  return file.string() + ": cannot be written: " + std::strerror(fault);
}

}  // namespace tandem
