#include "app/peer/text/peer_table_text.h"

#include <gmock/gmock.h>

namespace tandem {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

PeerTable Table() {
  PeerTable table;
  table.count = 2;
  table.rows[0] = {.peer = 1,
                   .loop_age_s = 0.05,
                   .delay_s = 0.025,
                   .coupled = true,
                   .stiffness = 321,
                   .link_force = 2.5,
                   .its_link_force = 2.25,
                   .disagreement = 0.1,
                   .mirror_age_s = 0.001,
                   .trapped = true,
                   .limits = {.travel_limited = 0.25, .over_capacity = 0.5, .contacts_full = 0},
                   .drops = {}};
  table.rows[0].drops[static_cast<std::size_t>(Drop::kReplayed)] = 7;
  table.rows[1].peer = 2;
  return table;
}

std::string NameOfPeer(PeerId peer) {
  return peer == 1 ? "anna" : "ben";
}

TEST(PeerTableText, ShowsDashesForUnknownValues) {
  const std::vector<std::string> lines = AsLines(Table(), NameOfPeer);
  ASSERT_EQ(lines.size(), 3U);
  for (const char* part : {"anna", "25 ms", "321 N/m", "2.50 N", "2.25 N", "10 %", "0.0 mm", "1 ms",
                           "replayed 7", "TRAPPED", "slowed 25 %, over capacity 50 %"}) {
    EXPECT_THAT(lines[1], HasSubstr(part));
  }
  EXPECT_THAT(lines[2], HasSubstr("ben"));
  EXPECT_THAT(lines[2], HasSubstr("none"));
  EXPECT_THAT(lines[2], Not(HasSubstr("0")));
  EXPECT_THAT(lines[2], Not(HasSubstr("TRAPPED")));
  // columns stand below their heads
  EXPECT_EQ(lines[0].find("coupling"), lines[1].find("321"));
  EXPECT_EQ(lines[0].find("dropped"), lines[2].find("none"));
}

TEST(PeerTableText, ExplainsOwnFrameLimits) {
  PeerTable table;
  table.own_limits = {.travel_limited = 0.004, .over_capacity = 0, .contacts_full = 1};
  const std::vector<std::string> lines = AsLines(table, NameOfPeer);
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_THAT(
      lines[1],
      HasSubstr("in the last second, in 0.4 % of the frames the travel limit slowed a body"));
  EXPECT_THAT(lines[2],
              HasSubstr("in 100 % of the frames a pair of bodies had more contacts than"));
}

TEST(PeerTableText, ReportUsesMillimetresAndMilliseconds) {
  const nlohmann::ordered_json rows = AsJson(Table(), NameOfPeer);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0]["name"], "anna");
  EXPECT_EQ(rows[0]["loop_age_ms"], 50.0);
  EXPECT_EQ(rows[0]["link_force_N"], 2.5);
  EXPECT_EQ(rows[0]["trapped"], true);
  EXPECT_EQ(rows[0]["limits"]["travel_limited_share"], 0.25);
  EXPECT_EQ(rows[0]["limits"]["over_capacity_share"], 0.5);
  EXPECT_EQ(rows[0]["limits"]["contacts_full_share"], 0.0);
  EXPECT_EQ(rows[0]["drops"]["replayed"], 7);
  EXPECT_EQ(rows[1]["drops"].size(), 0U);
}

}  // namespace
}  // namespace tandem
