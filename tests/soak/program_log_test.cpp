#include "tests/soak/program_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scratch_folder.h"

namespace tandem::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class ProgramLogs : public ::testing::Test {
 protected:
  void Say(const std::string& text, double now_s = 0) {
    std::ofstream(file_, std::ios::app) << text;
    log_.Read(now_s);
  }

  const ScratchFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "said";
  ProgramLog log_{file_};
};

// The lines are those of the product's orders: app/peer/text/peer_table_text.cpp.
TEST_F(ProgramLogs, TableListsCoupledPeersOnly) {
  Say("tandem: anna-1 is in session s (real-time priority)\n"
      "tandem: peer             delay     coupling  force\n"
      "tandem: ben-1            52 ms     80 N/m    1.20 N    1.20 N    0 %      0 mm      1 ms "
      "none\n"
      "tandem: cleo-2           -         -         -         -         -        -         - none\n"
      "tandem: ben-1: p+dd, gains as always\n"
      "tandem: in the last second, 3 % of your frames were slowed\n");
  ASSERT_EQ(log_.rows().size(), 2U);
  EXPECT_TRUE(log_.rows().at("ben-1").coupled);
  EXPECT_EQ(log_.rows().at("ben-1").delay_ms, 52);
  EXPECT_FALSE(log_.rows().at("cleo-2").coupled);
  EXPECT_LT(log_.rows().at("cleo-2").delay_ms, 0);
  EXPECT_EQ(log_.lines(), 1U);
}

TEST_F(ProgramLogs, StatusLineListsVisiblePeers) {
  Say("tandem: 120 samples/s; anna-1 52 ms, peg moved 3 mm (contact); ben-2 51 ms\ntandem: anna-1 "
      "is");
  EXPECT_THAT(log_.seen(), ElementsAre("anna-1", "ben-2"));
  EXPECT_EQ(log_.losses(), 0U);
  Say(" lost\ntandem: no active peer is here\n");
  EXPECT_EQ(log_.losses(), 1U);
  log_.Forget();
  EXPECT_THAT(log_.seen(), IsEmpty());
}

TEST_F(ProgramLogs, CountsThePeakLineRate) {
  for (int i = 0; i < 30; ++i) Say("tandem: news\n", i);
  EXPECT_EQ(log_.most_lines(), 11U);  // 0 to 10 s, both included
  EXPECT_EQ(log_.lines(), 30U);
}

TEST_F(ProgramLogs, DetectsNonFiniteNumbers) {
  Say("tandem: 120 samples/s; nancy-1 52 ms, peg moved 3 mm\n");
  EXPECT_EQ(log_.not_finite(), "");
  Say("tandem: ben-1            52 ms     80 N/m    -nan N    1.20 N\n");
  EXPECT_THAT(log_.not_finite(), ::testing::HasSubstr("-nan N"));
}

}  // namespace
}  // namespace tandem::testing
