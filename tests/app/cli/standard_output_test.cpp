// Tests that `tandem` does not end with code 0 where nobody gets what it prints.

#include <gmock/gmock.h>
#include <unistd.h>

#include "app/common/exit_codes.h"
#include "tests/app/cli/program_run.h"

namespace tandem {
namespace {

using testing::ExpectRefused;
using testing::ProgramOutput;
using testing::RunTandem;

TEST(StandardOutput, FullDiskIsAnErrorInOneLine) {
  for (const std::string command :
       {"simulate --first 3 --seeds 1 --json", "keys rights", "--version", "peer --help"}) {
    ASSERT_EQ(RunTandem(command).exit_code, kExitOk) << command;
    ExpectRefused(RunTandem(command + " >/dev/full"), kExitFile,
                  "tandem: stdout: the output could not be written completely");
  }
}

TEST(StandardOutput, ClosedReaderIsAnErrorWithoutAMessage) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  close(ends[0]);
  ASSERT_LT(ends[1], 10) << "a shell takes one digit";
  const ProgramOutput output = RunTandem("keys rights >&" + std::to_string(ends[1]));
  close(ends[1]);
  EXPECT_EQ(output.exit_code, kExitFile);
  EXPECT_EQ(output.err, "");
}

TEST(StandardOutput, ClosedOutputIsIgnoredWithoutPrinting) {
  const ScratchFolder scratch;
  const std::string keys = (scratch.path() / "keys").string();
  EXPECT_EQ(RunTandem("keys session " + keys + " >&-").exit_code, kExitOk);
}

}  // namespace
}  // namespace tandem
