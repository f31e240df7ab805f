// Tests that programs of the product end when they are told to, whatever they are in.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>

#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/process/child_processes.h"
#include "tests/support/machine/lag_meter.h"
#include "tests/support/machine/processor_wait.h"

namespace tandem {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

// bound on the time that a program takes itself
constexpr double kMostSeconds = 1.0;
constexpr double kMostPatience = 60.0;

std::string SessionName() {
  return "ends-" + std::to_string(std::random_device{}());
}

std::string TextOf(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

bool FileSays(const std::filesystem::path& file, const std::string& words, double seconds = 60) {
  for (double waited = 0; waited < seconds; waited += 0.02) {
    if (TextOf(file).find(words) != std::string::npos) return true;
    std::this_thread::sleep_for(milliseconds(20));
  }
  return false;
}

/// A program with a stdout and stderr of the test's choice, and an environment with one more word.
class Started {
 public:
  Started(std::vector<std::string> command, int out, const std::string& temporary = "") {
    pid_ = fork();
    if (pid_ != 0) return;
    dup2(out, STDOUT_FILENO);
    dup2(out, STDERR_FILENO);
    if (!temporary.empty()) setenv("TMPDIR", temporary.c_str(), 1);
    const int nothing = open("/dev/null", O_RDONLY);
    dup2(nothing, STDIN_FILENO);
    std::vector<char*> argv;
    for (std::string& word : command) argv.push_back(word.data());
    argv.push_back(nullptr);
    execv(argv[0], argv.data());
    _exit(127);
  }
  ~Started() {
    if (ended_) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Started(const Started&) = delete;
  Started& operator=(const Started&) = delete;

  pid_t pid() const { return pid_; }
  /// Sends the signal, and returns how long the program took to end, s, without the time in which
  /// others had the processors; a large number: it did not end. `partner`: a program that it says
  /// goodbye to.
  double SecondsToEnd(int signal, const Started* partner = nullptr) {
    testing::ProcessorWait wait(pid_);
    testing::ProcessorWait of_partner(partner != nullptr ? partner->pid() : 0);
    const testing::LagMeter lag;
    const auto began = std::chrono::steady_clock::now();
    kill(pid_, signal);
    for (;;) {
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
      if (waitpid(pid_, &status_, WNOHANG) == pid_) {
        ended_ = true;
        return took.count() - wait.Look() - of_partner.Look() -
               std::chrono::duration<double>(lag.worst()).count();
      }
      if (took.count() > kMostPatience) return 1e9;
      wait.Look();
      std::this_thread::sleep_for(milliseconds(2));
    }
  }
  bool EndsByItself() {
    for (double waited = 0; waited < kMostPatience; waited += 0.02) {
      if (waitpid(pid_, &status_, WNOHANG) == pid_) {
        ended_ = true;
        return true;
      }
      std::this_thread::sleep_for(milliseconds(20));
    }
    return false;
  }
  int status() const { return status_; }

 private:
  pid_t pid_ = -1;
  bool ended_ = false;
  int status_ = 0;
};

class File {
 public:
  explicit File(const std::filesystem::path& path)
      : fd_(open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600)) {}
  ~File() { close(fd_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

/// A pipe that is full: a program that writes to it waits.
class FullPipe {
 public:
  FullPipe() {
    EXPECT_EQ(pipe2(ends_.data(), O_CLOEXEC), 0);
    fcntl(ends_[1], F_SETPIPE_SZ, 4096);
    fcntl(ends_[1], F_SETFL, O_NONBLOCK);
    const std::array<char, 4096> bytes{};
    while (write(ends_[1], bytes.data(), bytes.size()) > 0) {
    }
    fcntl(ends_[1], F_SETFL, 0);
  }
  ~FullPipe() {
    CloseReader();
    close(ends_[1]);
  }
  FullPipe(const FullPipe&) = delete;
  FullPipe& operator=(const FullPipe&) = delete;
  int writer() const { return ends_[1]; }
  void CloseReader() {
    if (ends_[0] >= 0) close(ends_[0]);
    ends_[0] = -1;
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

std::vector<std::string> ControllerCommandLine(const std::string& session,
                                               const std::vector<std::string>& more = {}) {
  const std::filesystem::path scenes = TANDEM_SCENES;
  std::vector<std::string> words{
      TANDEM_PROGRAM, "peer",  "--session", session,
      "--interface",  "lo",    "--scene",   (scenes / "peg_in_slot.json").string(),
      "--hold",       "peg",   "--name",    "anna",
      "--capacity",   "20000", "--brief"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::vector<std::string> WatchWords(const std::string& session) {
  return {TANDEM_PROGRAM, "watch", "--session", session, "--interface", "lo", "--name", "vera"};
}

TEST(Ends, PeerWithABlockedStderrEndsWithinASecond) {
  const TemporaryFolder folder;
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
    const std::string session = SessionName();
    const File watched(folder.path() / std::to_string(signal));
    Started vera(WatchWords(session), watched.get());
    const FullPipe blocked;
    Started anna(ControllerCommandLine(session), blocked.writer());
    ASSERT_TRUE(FileSays(folder.path() / std::to_string(signal), "anna joined"));
    EXPECT_LT(anna.SecondsToEnd(signal, &vera), kMostSeconds);
    EXPECT_TRUE(FileSays(folder.path() / std::to_string(signal), "anna left"))
        << TextOf(folder.path() / std::to_string(signal));
    EXPECT_LT(vera.SecondsToEnd(SIGTERM), kMostSeconds);
  }
}

// Opened for writing, a pipe without a reader waits for one.
TEST(Ends, PeerWithABlockedReportEndsWithinASecond) {
  const TemporaryFolder folder;
  const std::filesystem::path report = folder.path() / "report";
  ASSERT_EQ(mkfifo(report.c_str(), 0600), 0);
  const std::string session = SessionName();
  const File watched(folder.path() / "watched");
  const File output(folder.path() / "said");
  Started vera(WatchWords(session), watched.get());
  Started anna(ControllerCommandLine(session, {"--report", report.string()}), output.get());
  ASSERT_TRUE(FileSays(folder.path() / "watched", "anna joined")) << TextOf(folder.path() / "said");
  EXPECT_LT(anna.SecondsToEnd(SIGTERM, &vera), kMostSeconds) << TextOf(folder.path() / "said");
  EXPECT_THAT(TextOf(folder.path() / "said"), HasSubstr("ended by force: " + report.string()));
  EXPECT_TRUE(FileSays(folder.path() / "watched", "anna left"))
      << TextOf(folder.path() / "watched");
  EXPECT_LT(vera.SecondsToEnd(SIGTERM), kMostSeconds);
}

TEST(Ends, PeerSurvivesItsClosedOutputAndWritesItsReport) {
  const TemporaryFolder folder;
  const std::string report = (folder.path() / "report").string();
  FullPipe pipe;
  pipe.CloseReader();
  Started anna(ControllerCommandLine(SessionName(), {"--seconds", "1", "--report", report}),
               pipe.writer());
  EXPECT_TRUE(anna.EndsByItself());
  ASSERT_TRUE(WIFEXITED(anna.status()));
  EXPECT_EQ(WEXITSTATUS(anna.status()), 0);
  std::ifstream stream(report);
  EXPECT_TRUE(nlohmann::json::parse(stream, nullptr, false).is_object());
}

// timeout(1) signals the program and then its group: one request comes as two signals
TEST(Ends, RequestOfTwoSignalsLeavesTheReport) {
  const TemporaryFolder folder;
  const std::string report = (folder.path() / "report").string();
  const File output(folder.path() / "anna");
  Started anna(ControllerCommandLine(SessionName(), {"--report", report}), output.get());
  ASSERT_TRUE(FileSays(folder.path() / "anna", "anna is in session"));
  kill(anna.pid(), SIGINT);
  std::this_thread::sleep_for(milliseconds(20));
  EXPECT_LT(anna.SecondsToEnd(SIGINT), kMostSeconds);
  ASSERT_TRUE(WIFEXITED(anna.status())) << WTERMSIG(anna.status());
  EXPECT_EQ(WEXITSTATUS(anna.status()), 0);
  std::ifstream stream(report);
  EXPECT_TRUE(nlohmann::json::parse(stream, nullptr, false).is_object());
}

// DDS waits a second by itself for readers that have not acknowledged all. A reader that was killed
// never does.
TEST(Ends, PeerEndsWithItsReportAfterItsViewerIsKilled) {
  const TemporaryFolder folder;
  for (const int after_ms : {0, 100, 400}) {
    const std::string session = SessionName();
    const std::string name = std::to_string(after_ms);
    const std::string report = (folder.path() / ("report" + name)).string();
    const File output(folder.path() / ("anna" + name));
    const File watched(folder.path() / ("vera" + name));
    Started anna(ControllerCommandLine(session, {"--report", report}), output.get());
    Started vera(WatchWords(session), watched.get());
    ASSERT_TRUE(FileSays(folder.path() / ("anna" + name), "vera (viewer) joined"))
        << TextOf(folder.path() / ("anna" + name));
    vera.SecondsToEnd(SIGKILL);
    std::this_thread::sleep_for(milliseconds(after_ms));
    EXPECT_LT(anna.SecondsToEnd(SIGTERM), kMostSeconds) << after_ms;
    ASSERT_TRUE(WIFEXITED(anna.status())) << after_ms;
    EXPECT_EQ(WEXITSTATUS(anna.status()), 0) << after_ms;
    std::ifstream stream(report);
    EXPECT_TRUE(nlohmann::json::parse(stream, nullptr, false).is_object()) << after_ms;
  }
}

/// Returns how often a program is told to end, at a moment drawn at random.
int Times() {
  const char* times = std::getenv("TANDEM_ENDS");
  return times != nullptr ? std::atoi(times) : 12;
}

TEST(Ends, SignalEndsAPeerWithinASecondAtAnyTime) {
  const TemporaryFolder folder;
  std::mt19937 random(18);
  std::uniform_real_distribution<double> moment(0.0, 1.5);
  std::vector<double> took;
  for (int i = 0; i < Times(); ++i) {
    const File output(folder.path() / "said");
    const FullPipe blocked;
    const std::string session = SessionName();
    Started peer(ControllerCommandLine(session), i % 2 == 0 ? blocked.writer() : output.get());
    std::this_thread::sleep_for(std::chrono::duration<double>(moment(random)));
    took.push_back(peer.SecondsToEnd(i % 3 == 0 ? SIGINT : SIGTERM));
    EXPECT_LT(took.back(), kMostSeconds) << i;
  }
  RecordProperty("slowest_ms", static_cast<int>(1000 * *std::ranges::max_element(took)));
}

TEST(Ends, SignalsEndViewersAndRelays) {
  const FullPipe blocked;
  const std::string session = SessionName();
  Started watch(WatchWords(session), blocked.writer());
  Started relay({TANDEM_PROGRAM, "relay", "--session", session, "--interface", "lo"},
                blocked.writer());
  std::this_thread::sleep_for(milliseconds(1500));
  EXPECT_LT(watch.SecondsToEnd(SIGTERM), kMostSeconds);
  EXPECT_LT(relay.SecondsToEnd(SIGTERM), kMostSeconds);
}

std::size_t FilesIn(const std::filesystem::path& folder) {
  std::error_code gone;
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& one : std::filesystem::directory_iterator(folder, gone))
    ++count;
  return count;
}

TEST(Ends, DemoAlwaysRemovesItsTemporaryFolder) {
  for (const int signal : {SIGINT, SIGTERM, SIGKILL}) {
    const TemporaryFolder folder;
    const std::filesystem::path temporary = folder.path() / "tmp";
    std::filesystem::create_directory(temporary);
    const File output(folder.path() / "said");
    Started demo({TANDEM_PROGRAM, "demo", "--headless", "--scene",
                  (std::filesystem::path(TANDEM_SCENES) / "bracket_actuator.json").string()},
                 output.get(), temporary.string());
    for (double waited = 0; waited < 60 && FilesIn(temporary) == 0; waited += 0.02) {
      std::this_thread::sleep_for(milliseconds(20));
    }
    ASSERT_GT(FilesIn(temporary), 0U) << TextOf(folder.path() / "said");
    std::this_thread::sleep_for(milliseconds(300));
    EXPECT_LT(demo.SecondsToEnd(signal), kMostSeconds);
    // a small process removes what a killed program leaves, and its programs end by themselves
    for (double waited = 0; waited < kMostPatience && FilesIn(temporary) > 0; waited += 0.02) {
      std::this_thread::sleep_for(milliseconds(20));
    }
    EXPECT_EQ(FilesIn(temporary), 0U) << "signal " << signal;
  }
}

TEST(Ends, DoctorsResponderEndsUnderAProbeFlood) {
  const TemporaryFolder folder;
  const File output(folder.path() / "said");
  Started doctor({TANDEM_PROGRAM, "doctor", "--answer"}, output.get());
  if (!FileSays(folder.path() / "said", "answering at UDP", 20)) {
    GTEST_SKIP() << "another program has the port: " << TextOf(folder.path() / "said");
  }
  std::atomic<bool> stop{false};
  std::thread flood([&stop] {
    const int out = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(7399);
    const std::string probe = "td-probe" + std::string(56, 'x');
    while (!stop) {
      sendto(out, probe.data(), probe.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    }
    close(out);
  });
  std::this_thread::sleep_for(milliseconds(500));
  EXPECT_LT(doctor.SecondsToEnd(SIGTERM), kMostSeconds);
  stop = true;
  flood.join();
}

}  // namespace
}  // namespace tandem
