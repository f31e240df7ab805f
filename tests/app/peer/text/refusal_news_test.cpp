#include "app/peer/text/refusal_news.h"

#include <gmock/gmock.h>

namespace tandem {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(RefusalNews, PacketFloodsAreReportedOncePerKind) {
  RefusalNews news;
  PacketCounts packets{};
  packets[static_cast<std::size_t>(PacketDrop::kNone)] = 1'000'000;
  packets[static_cast<std::size_t>(PacketDrop::kNewSender)] = RefusalNews::kLeastPackets - 1;
  EXPECT_THAT(news.Look(packets), IsEmpty());
  packets[static_cast<std::size_t>(PacketDrop::kNewSender)] = 100'000;
  EXPECT_THAT(news.Look(packets), ElementsAre(HasSubstr("announces more programs")));
  EXPECT_THAT(news.Look(packets), IsEmpty());
}

}  // namespace
}  // namespace tandem
