#include "engine/geometry/formats/remark_list.h"

#include <string>

#include <gmock/gmock.h>

namespace tandem {
namespace {

using ::testing::ElementsAre;

TEST(RemarkList, KindIsCountedWhateverItsReason) {
  RemarkList remarks;
  remarks.Count("line", "lines", "left out, the first with 'a'");
  EXPECT_THAT(remarks.Lines(), ElementsAre("1 line left out, the first with 'a'"));
  remarks.Count("line", "lines", "left out, the first with 'b'");
  remarks.Count("curve", "curves", "left out");
  EXPECT_THAT(remarks.Lines(),
              ElementsAre("2 lines left out, the first with 'a'", "1 curve left out"));
}

TEST(RemarkList, LinesBeyondTheFirstAreCounted) {
  RemarkList remarks;
  for (int i = 0; i < 20; ++i) remarks.Say("remark " + std::to_string(i));
  remarks.Say("remark 3");
  ASSERT_EQ(remarks.Lines().size(), 17U);
  EXPECT_EQ(remarks.Lines()[15], "remark 15");
  EXPECT_EQ(remarks.Lines()[16], "and 4 more remarks");
}

TEST(RemarkList, KindsBeyondTheFirstAreCounted) {
  RemarkList remarks;
  for (int i = 0; i < 100'000; ++i) {
    remarks.Count("one", "things of kind " + std::to_string(i), "left out");
  }
  ASSERT_EQ(remarks.Lines().size(), 17U);
  EXPECT_EQ(remarks.Lines()[16], "and 99984 more remarks");
}

}  // namespace
}  // namespace tandem
