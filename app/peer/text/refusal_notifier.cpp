#include "app/peer/text/refusal_notifier.h"

namespace tandem {
namespace {

// Returns what the user is told of refused packets; null: they are of no interest.
const char* WordsFor(PacketDrop reason) {
  switch (reason) {
    case PacketDrop::kNewSender:
      return "somebody announces more programs than there can be: this program refuses them";
    case PacketDrop::kForged:
      return "somebody forges announcements of programs: this program refuses them";
    case PacketDrop::kEndpoints:
      return "somebody announces more endpoints than a program can have: this program refuses them";
    case PacketDrop::kFlood:
      return "somebody floods this program with packets: it refuses the excess";
    default:
      return nullptr;
  }
}

}  // namespace

std::vector<std::string> RefusalNotifier::TakeNotifications(const PacketCounts& packets) {
  std::vector<std::string> news;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const auto reason = static_cast<PacketDrop>(i);
    const char* const words = WordsFor(reason);
    if (packets[i] < kLeastPackets || words == nullptr) continue;
    if (packets_told_.insert(reason).second) news.emplace_back(words);
  }
  return news;
}

}  // namespace tandem
