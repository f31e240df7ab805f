#include "app/view/model/hand/controller_log.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <string_view>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tandem {

Result<ControllerLog> ControllerLog::Open() {
  std::error_code failed;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(failed);
  if (failed) {
    return Error{"no temporary file can be made: " + failed.message() +
                 ": let TMPDIR name a folder that you may write to"};
  }
  std::string name = (folder / "tandem-controller-XXXXXX").string();
  const int file = mkostemp(name.data(), O_CLOEXEC | O_APPEND);
  if (file < 0) {
    return Error{name + ": " + std::strerror(errno) +
                 ": let TMPDIR name a folder that you may write to"};
  }
  unlink(name.c_str());
  return ControllerLog(file);
}

ControllerLog::ControllerLog(ControllerLog&& other) noexcept
    : file_(std::exchange(other.file_, -1)), last_(std::move(other.last_)) {}

ControllerLog::~ControllerLog() {
  if (file_ >= 0) close(file_);
}

void ControllerLog::Bound() {
  struct stat of_file {};
  if (fstat(file_, &of_file) != 0 || of_file.st_size <= kMostBytes) return;
  std::string last = LastLine();
  // the controller appends to the new end
  if (ftruncate(file_, 0) == 0) last_ = std::move(last);
}

std::string ControllerLog::LastLine() const {
  constexpr off_t kMost = 4096;  // bytes at the end; no line of the controller is longer
  struct stat of_file {};
  if (fstat(file_, &of_file) != 0) return {};
  std::string end(static_cast<std::size_t>(std::min(of_file.st_size, kMost)), '\0');
  const off_t begin = of_file.st_size - static_cast<off_t>(end.size());
  // pread(), since the controller shares the file's position
  const ssize_t read = pread(file_, end.data(), end.size(), begin);
  end.resize(static_cast<std::size_t>(std::max<ssize_t>(read, 0)));
  std::istringstream stream(end);
  std::string last;
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty()) last = line;
  }
  if (last.empty()) return last_;
  constexpr std::string_view kProgram = "tandem: ";
  return last.rfind(kProgram, 0) == 0 ? last.substr(kProgram.size()) : last;
}

}  // namespace tandem
