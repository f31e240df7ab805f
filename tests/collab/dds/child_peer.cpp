#include "tests/collab/dds/child_peer.h"

#include <algorithm>
#include <array>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/base/check.h"

namespace tandem::testing {

ChildPeer::ChildPeer(const std::string& session, PeerId id, const Options& options)
    : ChildPeer({TANDEM_DDS_TEST_PEER, session, std::to_string(id),
                 options.role == Role::kViewer ? "viewer" : "active",
                 std::to_string(options.claimed == 0 ? id : options.claimed),
                 std::to_string(options.port), std::to_string(options.peer_port), options.secure}) {
}

ChildPeer::ChildPeer(std::vector<std::string> command) {
  std::vector<char*> argv;
  for (std::string& word : command) argv.push_back(word.data());
  argv.push_back(nullptr);
  int in[2];
  int out[2];
  TANDEM_CHECK(pipe2(in, O_CLOEXEC) == 0 && pipe2(out, O_CLOEXEC) == 0);
  pid_ = fork();
  TANDEM_CHECK(pid_ >= 0);
  if (pid_ == 0) {
    dup2(in[0], STDIN_FILENO);
    dup2(out[1], STDOUT_FILENO);
    execv(argv[0], argv.data());
    _exit(127);
  }
  close(in[0]);
  close(out[1]);
  to_child_ = in[1];
  from_child_ = out[0];
}

ChildPeer::~ChildPeer() {
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  close(to_child_);
  close(from_child_);
}

void ChildPeer::Command(const std::string& line) {
  const std::string text = line + "\n";
  TANDEM_CHECK(write(to_child_, text.data(), text.size()) == static_cast<ssize_t>(text.size()));
}

void ChildPeer::Signal(int signal) {
  TANDEM_CHECK(kill(pid_, signal) == 0);
}

bool ChildPeer::Says(const std::string& line, std::chrono::milliseconds deadline) {
  const auto end = std::chrono::steady_clock::now() + deadline;
  while (output_.find("\n" + line + "\n") == std::string::npos) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - std::chrono::steady_clock::now());
    pollfd wait{from_child_, POLLIN, 0};
    if (left.count() <= 0 || poll(&wait, 1, static_cast<int>(left.count())) <= 0) return false;
    std::array<char, 1024> buffer;
    const ssize_t size = read(from_child_, buffer.data(), buffer.size());
    if (size <= 0) return false;
    output_.append(buffer.data(), static_cast<std::size_t>(size));
  }
  return true;
}

}  // namespace tandem::testing
