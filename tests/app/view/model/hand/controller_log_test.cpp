#include "app/view/model/hand/controller_log.h"

#include <string>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tandem {
namespace {

void Say(const ControllerLog& log, const std::string& words) {
  ASSERT_EQ(write(log.descriptor(), words.data(), words.size()),
            static_cast<ssize_t>(words.size()));
}

off_t SizeOf(const ControllerLog& log) {
  struct stat status {};
  EXPECT_EQ(fstat(log.descriptor(), &status), 0);
  return status.st_size;
}

TEST(ControllerLog, StaysWithinItsBoundAndKeepsTheLastLine) {
  Result<ControllerLog> log = ControllerLog::Open();
  ASSERT_TRUE(log) << log.error().what;
  EXPECT_EQ(log->LastLine(), "");
  const std::string line = "tandem: " + std::string(991, 'x') + "\n";
  const off_t most = ControllerLog::kMostBytes + static_cast<off_t>(line.size());
  for (int i = 0; i < 10'000; ++i) {
    Say(*log, line);
    log->Bound();
    ASSERT_LE(SizeOf(*log), most) << "10 MB were said";
    ASSERT_EQ(log->LastLine(), std::string(991, 'x'));
  }
  Say(*log, "tandem: the newest line\n");
  EXPECT_EQ(log->LastLine(), "the newest line");
}

TEST(ControllerLog, IsCompleteBelowItsBound) {
  Result<ControllerLog> log = ControllerLog::Open();
  ASSERT_TRUE(log) << log.error().what;
  Say(*log, std::string(1000, 'x') + "\n");
  log->Bound();
  EXPECT_EQ(SizeOf(*log), 1001);
}

}  // namespace
}  // namespace tandem
