#include "engine/base/files/regular_file.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;

TEST(RegularFile, ReadsTheBytesOfAFile) {
  const ScratchFolder scratch;
  const std::string bytes = std::string("a\0b\n", 4) + std::string(200'000, 'x');
  const Result<std::string> read = ReadWholeFile(scratch.Write("file", bytes), 1 << 20);
  ASSERT_TRUE(read);
  EXPECT_EQ(*read, bytes);
}

// A pipe without a writer would block whoever opens it, and a device would never end.
TEST(RegularFile, OpensOnlyRegularFiles) {
  const ScratchFolder scratch;
  const std::filesystem::path pipe = scratch.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const std::filesystem::path door = scratch.path() / "door";
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  door.string().copy(address.sun_path, sizeof address.sun_path - 1);
  const int listener = socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  for (const std::filesystem::path& file :
       {pipe, door, std::filesystem::path("/dev/zero"), scratch.path()}) {
    const Result<std::string> read = ReadWholeFile(file, 1 << 20);
    ASSERT_FALSE(read) << file;
    EXPECT_THAT(read.error().what, HasSubstr(file.string() + ": "));
  }
  close(listener);
  EXPECT_THAT(ReadWholeFile(pipe, 1).error().what, HasSubstr("it is not a regular file"));
  EXPECT_THAT(ReadWholeFile(scratch.path(), 1).error().what, HasSubstr("it is a folder"));
  EXPECT_EQ(ReadWholeFile("/nowhere/at all", 1).error().what,
            "/nowhere/at all: there is no such file");
}

TEST(RegularFile, RefusesOversizedFilesBeforeReading) {
  const ScratchFolder scratch;
  const std::filesystem::path file = scratch.Write("sparse", "");
  std::filesystem::resize_file(file, std::uintmax_t{1} << 40U);
  const Result<std::string> read = ReadWholeFile(file, 64U << 20U);
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().what, HasSubstr("is larger than 64 MiB"));
}

TEST(RegularFile, ReadsLinesAndStopsAtAnOverlongLine) {
  const ScratchFolder scratch;
  // each line with its end, as it stands in the file
  const auto lines_of = [&](const std::string& text) {
    LineReader reader(*RegularFile::Open(scratch.Write("lines", text)), 100'000);
    std::vector<std::string> lines;
    for (std::string line; reader.Next(line);) lines.push_back(line + (reader.ended() ? "$" : ""));
    return std::pair(lines, reader.too_long());
  };
  using Lines = std::vector<std::string>;
  EXPECT_EQ(lines_of(""), std::pair(Lines{}, false));
  EXPECT_EQ(lines_of("a\n\nb\n"), std::pair(Lines({"a$", "$", "b$"}), false));
  EXPECT_EQ(lines_of("a\nb"), std::pair(Lines({"a$", "b"}), false));
  const std::string longest(99'999, 'y');
  EXPECT_EQ(lines_of(longest + "\n" + longest + "\nz"),
            std::pair(Lines({longest + "$", longest + "$", "z"}), false));
  EXPECT_EQ(lines_of("a\n" + std::string(100'001, 'x') + "\nb\n"), std::pair(Lines({"a$"}), true));
}

TEST(PlainText, HasNoControlOrDirectionCharacters) {
  EXPECT_TRUE(IsPlainText("K\xc3\xb6nig \xe4\xb8\xad\xe6\x96\x87 \xf0\x9f\x94\xa9"));
  for (const char* bad : {"\x1b[31m", "a\nb", "\x7f", "\xc2\x9b", "\xe2\x80\xae", "\xff", "\xc3",
                          "\xed\xa0\x80", "\xc0\xaf", "\xf4\x90\x80\x80", "\xe2\x81\xa6"}) {
    EXPECT_FALSE(IsPlainText(bad)) << bad;
    EXPECT_TRUE(IsPlainText(PlainLine(bad))) << bad;
  }
  EXPECT_EQ(PlainLine("a\x1b[31mb\nc\xff"), "a?[31mb c?");
  // a letter of two bytes is not cut in two
  EXPECT_EQ(PlainLine("ab\xc3\xb6", 3), "ab...");
}

}  // namespace
}  // namespace tandem
