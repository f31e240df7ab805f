#include "app/peer/text/refusal_notifier.h"

#include <gmock/gmock.h>

namespace tandem {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(RefusalNotifier, PacketFloodsAreReportedOncePerKind) {
  RefusalNotifier news;
  PacketCounts packets{};
  packets[static_cast<std::size_t>(PacketDrop::kNone)] = 1'000'000;
  packets[static_cast<std::size_t>(PacketDrop::kNewSender)] = RefusalNotifier::kLeastPackets - 1;
  EXPECT_THAT(news.Check(packets), IsEmpty());
  packets[static_cast<std::size_t>(PacketDrop::kNewSender)] = 100'000;
  EXPECT_THAT(news.Check(packets), ElementsAre(HasSubstr("announces more programs")));
  EXPECT_THAT(news.Check(packets), IsEmpty());
}

}  // namespace
}  // namespace tandem
