#include "tests/network/hostile/packet_fuzzer.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include "engine/base/check.h"

namespace tandem::testing {

namespace {
constexpr std::size_t kHeader = 20;       // header of RTPS: magic, version, vendor, sender
constexpr std::size_t kFirstLength = 22;  // place of the first submessage's length
}  // namespace

std::vector<std::uint16_t> UdpPortsOf(pid_t process) {
  const std::filesystem::path folder = "/proc/" + std::to_string(process);
  std::set<std::string> inodes;
  std::error_code gone;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "fd", gone)) {
    const std::string target = std::filesystem::read_symlink(entry.path(), gone).string();
    if (target.rfind("socket:[", 0) == 0) inodes.insert(target.substr(8, target.size() - 9));
  }
  std::vector<std::uint16_t> ports;
  std::ifstream table(folder / "net" / "udp");
  std::string line;
  std::getline(table, line);  // the heading
  while (std::getline(table, line)) {
    std::istringstream words(line);
    std::vector<std::string> word;
    for (std::string one; words >> one;) word.push_back(one);
    if (word.size() < 10 || !inodes.contains(word[9])) continue;
    const std::string port = word[1].substr(word[1].find(':') + 1);
    ports.push_back(static_cast<std::uint16_t>(std::stoul(port, nullptr, 16)));
  }
  return ports;
}

PacketFuzzer::PacketFuzzer(std::vector<Packet> good, std::uint64_t seed)
    : good_(std::move(good)), random_(seed) {
  TANDEM_CHECK(!good_.empty());
}

unsigned char PacketFuzzer::SomeByte() {
  constexpr std::array<unsigned char, 5> kLimits{0, 1, 0x7f, 0x80, 0xff};
  const std::size_t which = Below(kLimits.size() + 1);
  return which < kLimits.size() ? kLimits[which] : static_cast<unsigned char>(random_());
}

const Packet& PacketFuzzer::Next() {
  if (Below(20) == 0) {
    constexpr std::array<std::size_t, 12> kSizes{0, 1, 3, 4, 7, 8, 16, 19, 20, 21, 200, 1400};
    packet_.resize(kSizes[Below(kSizes.size())]);
    for (unsigned char& byte : packet_) byte = static_cast<unsigned char>(random_());
  } else {
    packet_ = good_[Below(good_.size())];
    Mutate();
  }
  return packet_;
}

void PacketFuzzer::Mutate() {
  if (Below(4) == 0 && packet_.size() > kHeader) packet_.resize(4 + Below(packet_.size() - 4));
  constexpr std::array<std::size_t, 6> kChanges{0, 1, 1, 2, 4, 8};
  const std::size_t changes = kChanges[Below(kChanges.size())];
  for (std::size_t i = 0; i < changes && !packet_.empty(); ++i) {
    // the header seldom: a packet without it is not looked at
    const std::size_t from = Below(10) == 0 || packet_.size() <= kHeader ? 0 : kHeader;
    packet_[from + Below(packet_.size() - from)] = SomeByte();
  }
  if (Below(5) == 0 && packet_.size() > kFirstLength + 2) {
    packet_[kFirstLength] = SomeByte();
    packet_[kFirstLength + 1] = SomeByte();
  }
  const Packet& other = good_[Below(good_.size())];
  if (Below(10) == 0 && other.size() > kHeader) {
    packet_.insert(packet_.end(), other.begin() + kHeader, other.end());
  }
}

}  // namespace tandem::testing
