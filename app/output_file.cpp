#include "app/output_file.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
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
    const int made = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    fault = made >= 0 ? 0 : errno;
    if (made >= 0) {
      close(made);
      unlink(file.c_str());
    }
  }
  if (fault == 0) return {};
  return file.string() + ": cannot be written: " + std::strerror(fault);
}

}  // namespace tandem
