#include "engine/realtime/line_writer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <string>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace tandem {
namespace {

using std::chrono::milliseconds;

class Pipe {
 public:
  Pipe() { EXPECT_EQ(pipe2(ends_.data(), O_CLOEXEC), 0); }
  ~Pipe() {
    CloseReader();
    close(ends_[1]);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  int writer() const { return ends_[1]; }
  void CloseReader() {
    if (ends_[0] >= 0) close(ends_[0]);
    ends_[0] = -1;
  }
  std::string Read() const {
    std::array<char, 1 << 16> text{};
    const ssize_t size = read(ends_[0], text.data(), text.size());
    return {text.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))};
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

/// Makes a writer that never ends, as the product's own.
LineWriter& WriterOf(int fd) {
  return *new LineWriter(fd);
}

TEST(LineWriter, WritesLinesInOrder) {
  const Pipe pipe;
  LineWriter& writer = WriterOf(pipe.writer());
  for (int i = 0; i < 100; ++i) writer.WriteLine(std::to_string(i));
  ASSERT_TRUE(writer.Flush(milliseconds(10'000)));
  std::string expected;
  for (int i = 0; i < 100; ++i) expected += std::to_string(i) + '\n';
  EXPECT_EQ(pipe.Read(), expected);
  EXPECT_EQ(writer.dropped(), 0U);
}

TEST(LineWriter, BlockedPipeDelaysNoCallerAndDropsAreCounted) {
  const Pipe pipe;
  const int room = fcntl(pipe.writer(), F_SETPIPE_SZ, 4096);
  ASSERT_GE(room, 4096);
  LineWriter& writer = WriterOf(pipe.writer());
  const std::string line(1000, 'x');
  constexpr std::uint64_t kLines = 100'000;
  const auto began = std::chrono::steady_clock::now();
  for (std::uint64_t i = 0; i < kLines; ++i) writer.WriteLine(line);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  EXPECT_LT(took.count(), 5.0);
  EXPECT_FALSE(writer.Flush(milliseconds(50)));
  // all texts but those that wait and those that the pipe holds
  const std::uint64_t kept = LineWriter::kMostTexts + static_cast<std::uint64_t>(room) / 1000 + 1;
  EXPECT_GE(writer.dropped(), kLines - kept);
  // once somebody reads, they are told
  std::string all;
  while (all.find(" more lines found no room)\n") == std::string::npos) {
    const std::string more = pipe.Read();
    ASSERT_FALSE(more.empty());
    all += more;
  }
}

// ESC ] 0 ; … BEL sets a terminal's title, ESC [ 2 J clears it, and a line end begins a line that
// looks like the program's own
TEST(LineWriter, LineCarriesNoControlsToATerminal) {
  const Pipe pipe;
  LineWriter& writer = WriterOf(pipe.writer());
  writer.WriteLine("session \x1b]0;PWNED\x07\x1b[2J\ntandem: run this\x7f\u009b1m Čeněk");
  ASSERT_TRUE(writer.Flush(milliseconds(10'000)));
  EXPECT_EQ(pipe.Read(), "session ?]0;PWNED??[2J?tandem: run this??1m Čeněk\n");
}

TEST(LineWriter, ClosedReaderIsNoError) {
  Pipe pipe;
  LineWriter& writer = WriterOf(pipe.writer());
  pipe.CloseReader();
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  writer.WriteLine("to nobody");
  EXPECT_TRUE(writer.Flush(milliseconds(10'000)));
  EXPECT_EQ(writer.dropped(), 1U);
  std::signal(SIGPIPE, before);
}

}  // namespace
}  // namespace tandem
