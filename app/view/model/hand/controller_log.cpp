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
    : file_(std::exchange(other.file_, -1)), mark_(other.mark_), last_(std::move(other.last_)) {}

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

namespace {

/// Returns the bytes of a file from `begin` to its end, but at most the last `most` of them.
std::string EndOf(int file, off_t begin, off_t most) {
  struct stat of_file {};
  if (fstat(file, &of_file) != 0) return {};
  begin = std::clamp<off_t>(begin, std::max<off_t>(of_file.st_size - most, 0), of_file.st_size);
  std::string end(static_cast<std::size_t>(of_file.st_size - begin), '\0');
  // pread(), since the controller shares the file's position
  const ssize_t read = pread(file, end.data(), end.size(), begin);
  end.resize(static_cast<std::size_t>(std::max<ssize_t>(read, 0)));
  return end;
}

std::string WithoutProgram(const std::string& line) {
  constexpr std::string_view kProgram = "tandem: ";
  return line.rfind(kProgram, 0) == 0 ? line.substr(kProgram.size()) : line;
}

}  // namespace

std::string ControllerLog::LastLine() const {
  constexpr off_t kMost = 4096;  // bytes at the end; no line of the controller is longer
  std::istringstream stream(EndOf(file_, 0, kMost));
  std::string last;
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty()) last = line;
  }
  return last.empty() ? last_ : WithoutProgram(last);
}

void ControllerLog::Mark() {
  struct stat of_file {};
  mark_ = fstat(file_, &of_file) == 0 ? of_file.st_size : 0;
}

std::vector<std::string> ControllerLog::LinesSinceMark() const {
  constexpr off_t kMost = 16384;  // bytes
  std::istringstream stream(EndOf(file_, mark_, kMost));
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty()) lines.push_back(WithoutProgram(line));
  }
  return lines;
}

}  // namespace tandem
