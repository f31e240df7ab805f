#include "app/invite/given_line.h"

#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

namespace tandem {
namespace {

/// A program that asks for an invitation at a terminal of its own.
class AskingProgram {
 public:
  AskingProgram() : pid_(forkpty(&terminal_, nullptr, nullptr, nullptr)) {
    if (pid_ != 0) return;
    const Result<std::string> line = GivenLine("-");
    _exit(line && *line == "tandem://a#b" ? 0 : 1);
  }
  ~AskingProgram() {
    if (pid_ > 0) kill(pid_, SIGKILL);
    close(terminal_);
  }
  AskingProgram(const AskingProgram&) = delete;
  AskingProgram& operator=(const AskingProgram&) = delete;

  bool Echoes() const {
    termios now{};
    return tcgetattr(terminal_, &now) == 0 && (now.c_lflag & ECHO) != 0;
  }
  bool WaitsWithoutEcho() const {
    for (int i = 0; i < 1000 && Echoes(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return !Echoes();
  }
  void Type(const std::string& keys) const {
    EXPECT_EQ(write(terminal_, keys.data(), keys.size()), static_cast<ssize_t>(keys.size()));
  }
  /// Waits for its end, and returns how waitpid() tells of it.
  int End() {
    int status = -1;
    waitpid(pid_, &status, 0);
    pid_ = 0;
    return status;
  }

 private:
  int terminal_ = -1;
  pid_t pid_;
};

TEST(GivenLine, LineIsReadWithoutEcho) {
  AskingProgram program;
  ASSERT_TRUE(program.WaitsWithoutEcho());
  program.Type("tandem://a#b\n");
  const int status = program.End();
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

TEST(GivenLine, SignalThatEndsTheProgramLeavesTheTerminalWithItsEcho) {
  for (const char* key : {"\x03", "\x1C"}) {  // Ctrl-C, Ctrl-backslash
    AskingProgram program;
    ASSERT_TRUE(program.WaitsWithoutEcho());
    program.Type(key);
    bool echoes = false;
    for (int i = 0; i < 1000 && !echoes; ++i) {
      echoes = program.Echoes();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_TRUE(echoes);
    EXPECT_TRUE(WIFSIGNALED(program.End()));
  }
}

}  // namespace
}  // namespace tandem
