#include "app/peer/text/refusal_notifier.h"

#include <gmock/gmock.h>

namespace tandem {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(RefusalNotifier, PacketFloodsAreReportedOncePerKind) {
  RefusalNotifier notifier;
  PacketCounts packets{};
  packets[static_cast<std::size_t>(PacketDrop::kNone)] = 1'000'000;
  packets[static_cast<std::size_t>(PacketDrop::kNewSender)] = RefusalNotifier::kLeastPackets - 1;
  EXPECT_THAT(notifier.TakeNotifications(packets), IsEmpty());
  packets[static_cast<std::size_t>(PacketDrop::kNewSender)] = 100'000;
  EXPECT_THAT(notifier.TakeNotifications(packets),
              ElementsAre(HasSubstr("announces more programs")));
  EXPECT_THAT(notifier.TakeNotifications(packets), IsEmpty());
}

}  // namespace
}  // namespace tandem
