#include "app/process/program_answer.h"

#include <csignal>
#include <utility>

#include <sys/mman.h>
#include <unistd.h>

#include "app/common/program_folders.h"

namespace tandem {

ProgramAnswer::ProgramAnswer(const std::string& program, const std::vector<std::string>& words,
                             const std::string& to)
    : descriptor_(memfd_create("tandem-answer", MFD_CLOEXEC)) {
  std::vector<std::string> command{ProgramFolder() / program};
  command.insert(command.end(), words.begin(), words.end());
  command.insert(command.end(), {to, std::to_string(descriptor_)});
  Result<ChildProcess> started = ChildProcess::Start(command, descriptor_);
  if (started) process_.emplace(*std::move(started));
}

ProgramAnswer::~ProgramAnswer() {
  close(descriptor_);
}

std::optional<int> ProgramAnswer::Wait(std::chrono::milliseconds timeout) {
  if (!process_) return std::nullopt;
  const std::optional<int> code = process_->Wait(timeout);
  if (!code) process_->Signal(SIGKILL);
  return code;
}

std::string ProgramAnswer::text() const {
  std::string text;
  char block[4096];
  lseek(descriptor_, 0, SEEK_SET);
  for (ssize_t size = 0; (size = read(descriptor_, block, sizeof block)) > 0;) {
    text.append(block, static_cast<std::size_t>(size));
  }
  return text;
}

}  // namespace tandem
