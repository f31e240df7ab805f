#include "app/cli/refusal_news.h"

#include <gmock/gmock.h>

namespace tandem {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string NameOfVic(PeerId) {
  return "vic";
}

TEST(RefusalNews, EachProgramAndFaultIsToldOnce) {
  DropTable drops;
  RefusalNews news;
  EXPECT_THAT(news.Look(drops, NameOfVic), IsEmpty());
  for (int i = 0; i < 100'000; ++i) drops.Count(7, Drop::kFlood);
  EXPECT_THAT(news.Look(drops, NameOfVic), ElementsAre(HasSubstr("vic sends more than any sound")));
  for (int i = 0; i < 100'000; ++i) drops.Count(7, Drop::kFlood);
  EXPECT_THAT(news.Look(drops, NameOfVic), IsEmpty());
  for (int i = 0; i < 100; ++i) drops.Count(0, Drop::kManyKeys);
  EXPECT_THAT(news.Look(drops, NameOfVic), ElementsAre(HasSubstr("somebody speaks of more bodies")));
}

TEST(RefusalNews, AFewAreAnAccident) {
  DropTable drops;
  for (std::uint64_t i = 1; i < RefusalNews::kLeast; ++i) drops.Count(7, Drop::kFlood);
  EXPECT_THAT(RefusalNews().Look(drops, NameOfVic), IsEmpty());
}

TEST(RefusalNews, FloodsOfPacketsAreToldOnceByTheirKind) {
  RefusalNews news;
  PacketCounts packets{};
  packets[static_cast<std::size_t>(PacketDrop::kNone)] = 1'000'000;
  packets[static_cast<std::size_t>(PacketDrop::kNewSender)] = RefusalNews::kLeastPackets - 1;
  EXPECT_THAT(news.Look(packets), IsEmpty());
  packets[static_cast<std::size_t>(PacketDrop::kNewSender)] = 100'000;
  EXPECT_THAT(news.Look(packets), ElementsAre(HasSubstr("announces more programs")));
  EXPECT_THAT(news.Look(packets), IsEmpty());
}

TEST(RefusalNews, InventedSendersFillNoMemory) {
  DropTable drops;
  RefusalNews news;
  std::size_t lines = 0;
  for (PeerId peer = 1; peer <= 1000; ++peer) {
    for (int i = 0; i < 50; ++i) drops.Count(peer, Drop::kFlood);
    lines += news.Look(drops, NameOfVic).size();
  }
  EXPECT_LE(lines, RefusalNews::kMostTold);
}

}  // namespace
}  // namespace tandem
