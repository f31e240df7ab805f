#include "collab/dds/transport/announcements.h"

#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "engine/base/units.h"

namespace tandem {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Writes RTPS 2.5 as sections 9.4 and 10 of its text have it.
class PacketText {
 public:
  explicit PacketText(bool little) : little_(little) {}

  PacketText& Number(std::uint32_t value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * (little_ ? i : size - 1 - i))));
    }
    return *this;
  }
  PacketText& Raw(const Bytes& bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return *this;
  }
  PacketText& Parameter(std::uint16_t id, const Bytes& value) {
    return Number(id, 2).Number(static_cast<std::uint32_t>(value.size()), 2).Raw(value);
  }
  PacketText& TextParameter(std::uint16_t id, const std::string& text) {
    PacketText value(little_);
    value.Number(static_cast<std::uint32_t>(text.size() + 1), 4);
    for (const char c : text) value.bytes_.push_back(static_cast<std::uint8_t>(c));
    value.bytes_.push_back(0);
    while (value.bytes_.size() % 4 != 0) value.bytes_.push_back(0);
    return Parameter(id, value.bytes_);
  }
  PacketText& Submessage(std::uint8_t kind, std::uint8_t flags, const Bytes& body) {
    bytes_.push_back(kind);
    bytes_.push_back(static_cast<std::uint8_t>(flags | (little_ ? 1 : 0)));
    return Number(static_cast<std::uint32_t>(body.size()), 2).Raw(body);
  }
  const Bytes& bytes() const { return bytes_; }

 private:
  bool little_;
  Bytes bytes_;
};

struct Wanted {
  bool little = true;
  std::string tag = "tandem/press%201";
  bool secured = false;
  bool inline_qos = false;
  Bytes writer = {0x00, 0x01, 0x00, 0xC2};
  std::vector<std::pair<std::uint16_t, Bytes>> more = {};  // parameters
};

Bytes PacketOf(const Wanted& wanted) {
  PacketText list(wanted.little);
  list.Parameter(0x0015, {2, 5, 0, 0});
  if (wanted.secured) list.Parameter(0x1001, {1, 2, 3, 4});
  for (const auto& [id, value] : wanted.more) list.Parameter(id, value);
  list.TextParameter(0x4014, wanted.tag).Parameter(0x0001, {});
  PacketText data(wanted.little);
  data.Number(0, 2).Number(16, 2).Raw({0, 0, 0, 0}).Raw(wanted.writer).Number(0, 4).Number(1, 4);
  if (wanted.inline_qos) data.Parameter(0x0071, {0, 0, 0, 1}).Parameter(0x0001, {});
  data.Raw({0, static_cast<std::uint8_t>(wanted.little ? 3 : 2), 0, 0}).Raw(list.bytes());
  PacketText packet(wanted.little);
  packet.Raw({'R', 'T', 'P', 'S', 2, 5, 1, 16}).Raw({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  packet.Submessage(0x09, 0, {0, 0, 0, 0, 0, 0, 0, 0});  // a time stamp
  packet.Submessage(0x15, wanted.inline_qos ? 0x06 : 0x04, data.bytes());
  return packet.bytes();
}

TEST(Announcement, CarriesSessionProgramAndSecurity) {
  for (const bool little : {true, false}) {
    for (const bool secured : {true, false}) {
      for (const bool inline_qos : {true, false}) {
        const auto read = ReadAnnouncement(
            PacketOf({.little = little, .secured = secured, .inline_qos = inline_qos}));
        ASSERT_TRUE(read) << little << secured << inline_qos;
        EXPECT_EQ(read->session, (AnnouncedSession{"press 1", secured}));
        EXPECT_EQ(read->program[0], 1);
        EXPECT_EQ(read->program[11], 12);
      }
    }
  }
}

/// Returns the value of an IPv4 locator (RTPS 2.5, section 9.3.2.4).
Bytes Locator(bool little, const Bytes& address) {
  PacketText value(little);
  value.Number(1, 4).Number(7410, 4).Raw(Bytes(12, 0)).Raw(address);
  return value.bytes();
}

// DEFAULT_UNICAST_LOCATOR, METATRAFFIC_UNICAST_LOCATOR and a multicast locator
TEST(Announcement, UnicastAddressesAreReplacedAndNoOther) {
  for (const bool little : {true, false}) {
    const auto packet = [little](const Bytes& data_at, const Bytes& discovery_at) {
      return PacketOf({.little = little,
                       .more = {{0x0031, Locator(little, data_at)},
                                {0x0032, Locator(little, discovery_at)},
                                {0x0033, Locator(little, {239, 255, 0, 1})}}});
    };
    const Bytes bridge{172, 17, 0, 1};
    const Bytes router{203, 0, 113, 1};
    Bytes changed = packet(bridge, router);
    std::uint32_t from = 0;
    std::memcpy(&from, Bytes{10, 9, 0, 2}.data(), 4);
    std::uint32_t kept = 0;
    std::memcpy(&kept, router.data(), 4);
    ReplaceAnnouncedAddresses(changed, from, [kept](std::uint32_t announced) {
      return announced != kept;
    });
    EXPECT_EQ(changed, packet({10, 9, 0, 2}, router)) << little;
    // another writer's packet is not one in which a program announces itself
    Bytes other = PacketOf({.little = little,
                            .writer = {0, 0, 0x03, 0xC2},
                            .more = {{0x0031, Locator(little, bridge)}}});
    const Bytes before = other;
    ReplaceAnnouncedAddresses(other, from, [](std::uint32_t) {
      return true;
    });
    EXPECT_EQ(other, before);
  }
}

TEST(Announcement, IgnoresForeignPackets) {
  EXPECT_FALSE(ReadAnnouncement(PacketOf({.tag = "other/press"})));
  EXPECT_FALSE(ReadAnnouncement(PacketOf({.tag = ""})));
  EXPECT_FALSE(ReadAnnouncement(PacketOf({.writer = {0, 0, 0x03, 0xC2}})));
  EXPECT_FALSE(ReadAnnouncement({}));
  const std::string text = "GET / HTTP/1.1\r\nHost: nobody\r\n\r\n";
  EXPECT_FALSE(ReadAnnouncement(Bytes(text.begin(), text.end())));
}

// Anybody who reaches the port may send anything.
TEST(Announcement, DamagedPacketCausesNoReadOutOfBounds) {
  const Bytes whole = PacketOf({.secured = true, .inline_qos = true});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes torn(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(ReadAnnouncement(torn)) << size;
  }
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const int value : {0, 1, 0x7F, 0x80, 0xFF}) {
      Bytes altered = whole;
      altered[i] = static_cast<std::uint8_t>(value);
      const auto read = ReadAnnouncement(altered);
      if (read) {
        EXPECT_LE(read->session.name.size(), whole.size());
      }
    }
  }
}

TEST(Announcement, NamesAreSafeToPrint) {
  EXPECT_EQ(SessionOfTag("tandem/a%1B%5B2J%0A"), "a?[2J?");
  EXPECT_EQ(SessionOfTag("tandem/100%"), "100%");
  EXPECT_EQ(SessionOfTag("tandem/%zz%"), "%zz%");
  EXPECT_FALSE(SessionOfTag("tandem/" + std::string(1000, 'x')));
}

TEST(AnnouncedPrograms, AreForgottenWhenAnnouncementsStop) {
  AnnouncedPrograms programs;
  const Announcement ended{{1}, {"ended", false}};
  const Announcement here{{2}, {"here", true}};
  const Announcement self{{3}, {"own", false}};
  for (std::int64_t i = 0; i < 4; ++i) {
    if (i == 0) programs.Note(ended, 0);
    programs.Note(here, i * 2 * kSecondNs);
    programs.Note(self, i * 2 * kSecondNs);
  }
  using ::testing::ElementsAre;
  const std::set<ProgramId> own{self.program};
  EXPECT_THAT(programs.Sessions(own, 2 * kSecondNs),
              ElementsAre(AnnouncedSession{"ended", false}, AnnouncedSession{"here", true}));
  EXPECT_THAT(programs.Sessions(own, 8 * kSecondNs), ElementsAre(AnnouncedSession{"here", true}));
  EXPECT_THAT(programs.Sessions(own, 20 * kSecondNs), ElementsAre());
}

// A flood of forged announcements costs nothing.
TEST(AnnouncedPrograms, AreKeptUpToANumber) {
  AnnouncedPrograms programs;
  for (int i = 0; i < 10'000; ++i) {
    programs.Note({{}, {std::to_string(i), false}}, 0);
  }
  EXPECT_EQ(programs.Sessions({}, 0).size(), AnnouncedPrograms::kMost);
}

}  // namespace
}  // namespace tandem
