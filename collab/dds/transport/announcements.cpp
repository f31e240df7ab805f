#include "collab/dds/transport/announcements.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <string_view>

#include "engine/base/hash.h"
#include "engine/base/text/clean_text.h"

namespace tandem {
namespace {

// RTPS 2.5, sections 9.4 and 9.6; the parameters by their names there
constexpr std::size_t kRtpsHeader = 20;
constexpr std::size_t kProgramAt = 8;  // id of the sending program
constexpr std::uint8_t kPad = 0x01;
constexpr std::uint8_t kInfoTimestamp = 0x09;
constexpr std::uint8_t kInfoSource = 0x0c;
constexpr std::uint8_t kData = 0x15;
constexpr std::uint8_t kDataFragment = 0x16;
constexpr std::uint8_t kLittleEndian = 0x01;
constexpr std::uint8_t kInlineQos = 0x02;
constexpr std::uint32_t kToInlineQos = 16;  // counted from the field itself
constexpr std::uint32_t kSpdpWriter = 0x000100C2;
constexpr std::uint32_t kSecureSpdpWriter = 0xFF0101C2;
constexpr std::uint32_t kSedpTopics = 0x000002C2;
constexpr std::uint32_t kSedpWriters = 0x000003C2;
constexpr std::uint32_t kSedpReaders = 0x000004C2;
constexpr std::uint16_t kSentinel = 0x0001;
constexpr std::uint16_t kLeaseDuration = 0x0002;
constexpr std::uint16_t kParticipantId = 0x0050;
constexpr std::uint16_t kBuiltinEndpoints = 0x0058;
constexpr std::uint16_t kStatusInfo = 0x0071;
constexpr std::uint16_t kDefaultUnicastLocator = 0x0031;
constexpr std::uint16_t kMetatrafficUnicastLocator = 0x0032;
constexpr std::uint32_t kUdp4Locator = 1;
constexpr std::size_t kLocatorBytes = 24;
constexpr std::size_t kLocatorAddressAt = 20;
constexpr std::uint16_t kDomainTag = 0x4014;
constexpr std::uint16_t kIdentityToken = 0x1001;
constexpr std::uint16_t kVendorVersion = 0x8007;  // Cyclone's own
constexpr std::uint32_t kLeadsOthers = 1U << 4U;  // its flag of a program on which others depend
constexpr std::uint16_t kParametersLittle = 0x0003;
constexpr std::uint16_t kParametersBig = 0x0002;

// writers that announce the participant, its writers and its readers
constexpr std::uint32_t kAnnouncers = 0x15;

/// Takes numbers from the front of bytes. After the end all are zero, and good() is false.
class ByteCursor {
 public:
  ByteCursor(std::span<const std::uint8_t> bytes, bool little) : bytes_(bytes), little_(little) {}

  std::uint32_t Take(std::size_t size) {
    std::uint32_t value = 0;
    const std::span<const std::uint8_t> part = Bytes(size);
    for (std::size_t i = 0; i < part.size(); ++i) {
      value |= std::uint32_t{part[i]} << (8 * (little_ ? i : part.size() - 1 - i));
    }
    return value;
  }
  std::span<const std::uint8_t> Bytes(std::size_t size) {
    if (size > bytes_.size()) {
      good_ = false;
      bytes_ = {};
      return {};
    }
    const std::span<const std::uint8_t> part = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return part;
  }
  bool good() const { return good_; }
  std::span<const std::uint8_t> rest() const { return bytes_; }

 private:
  std::span<const std::uint8_t> bytes_;
  bool little_;
  bool good_ = true;
};

/// Calls use(parameter, value) for each parameter of a list. Returns false where the list's end is
/// missing.
template <typename Use>
bool ForEachParameter(ByteCursor& list, Use use) {
  while (list.good()) {
    const auto parameter = static_cast<std::uint16_t>(list.Take(2));
    const std::uint32_t size = list.Take(2);
    if (parameter == kSentinel) return list.good();
    use(parameter, list.Bytes(size));
  }
  return false;
}

std::optional<AnnouncedSession> ReadParticipant(std::span<const std::uint8_t> data) {
  ByteCursor head(data, false);
  const std::uint32_t encoding = head.Take(2);
  head.Take(2);
  if (encoding != kParametersLittle && encoding != kParametersBig) return std::nullopt;
  const bool little = encoding == kParametersLittle;
  ByteCursor list(head.rest(), little);
  std::optional<std::string> name;
  bool secured = false;
  const bool whole =
      ForEachParameter(list, [&](std::uint16_t parameter, std::span<const std::uint8_t> value) {
        secured = secured || parameter == kIdentityToken;
        if (parameter != kDomainTag) return;
        ByteCursor text(value, little);
        const std::uint32_t size = text.Take(4);  // includes the final zero
        const std::span<const std::uint8_t> bytes = text.Bytes(size);
        if (bytes.empty()) return;
        name = SessionOfTag(std::string(bytes.begin(), bytes.end() - 1));
      });
  if (!whole || !name) return std::nullopt;
  return AnnouncedSession{*name, secured};
}

}  // namespace

std::optional<std::string> SessionOfTag(const std::string& tag) {
  constexpr std::string_view kOurs = "tandem/";
  if (tag.size() > kOurs.size() + 3 * kMaxSessionName || tag.rfind(kOurs, 0) != 0) {
    return std::nullopt;
  }
  std::string name;
  for (std::size_t i = kOurs.size(); i < tag.size(); ++i) {
    char c = tag[i];
    unsigned code = 0;
    const char* digits = tag.data() + i + 1;
    if (c == '%' && i + 2 < tag.size() &&
        std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2) {
      c = static_cast<char>(code);
      i += 2;
    }
    name += c;
  }
  return CleanText(name);
}

namespace {

/// A DATA submessage: its writer, by the last four bytes of its id, and its body. Or the notice
/// that what follows is another program's.
struct DataFound {
  bool of_another = false;
  std::uint32_t writer = 0;
  bool whole = false;                  // not a fragment, and in the usual layout
  bool goodbye = false;                // ends the instance that it is about
  std::span<const std::uint8_t> body;  // only if whole
};

/// Reads the fields between the writer's id and the body, and the body.
void ReadBody(ByteCursor data, bool inline_qos, DataFound& found) {
  data.Bytes(8);  // sequence number
  int statuses = 0;
  found.whole = true;
  if (inline_qos) {
    found.whole =
        ForEachParameter(data, [&](std::uint16_t parameter, std::span<const std::uint8_t> value) {
          if (parameter != kStatusInfo) return;
          const bool ended = value.size() >= 4 && (value[3] & 3U) != 0;
          found.goodbye = ended && (statuses == 0 || found.goodbye);
          ++statuses;
        });
  }
  found.whole = found.whole && data.good();
  found.body = data.rest();
}

/// Calls use(data) for each DATA submessage of a packet, until that returns true. Returns false
/// where the packet is not RTPS or no call returned true. It goes through a packet as Cyclone does,
/// and ends where Cyclone does.
template <typename Use>
bool AnyData(std::span<const std::uint8_t> packet, Use use) {
  if (packet.size() < kRtpsHeader || std::memcmp(packet.data(), "RTPS", 4) != 0) return false;
  std::span<const std::uint8_t> rest = packet.subspan(kRtpsHeader);
  while (rest.size() >= 4) {
    const std::uint8_t kind = rest[0];
    const std::uint8_t flags = rest[1];
    const bool little = (flags & kLittleEndian) != 0;
    std::size_t size = ByteCursor(rest.subspan(2), little).Take(2);
    // the last submessage may leave its size out; these two kinds may be empty
    if (size == 0 && kind != kPad && kind != kInfoTimestamp) size = rest.size() - 4;
    if (size > rest.size() - 4) return false;
    const std::span<const std::uint8_t> body = rest.subspan(4, size);
    rest = rest.subspan(4 + size);
    if (kind == kInfoSource) {
      DataFound found;
      const std::span<const std::uint8_t> own = packet.subspan(kProgramAt, ProgramId{}.size());
      found.of_another =
          size < 8 + own.size() || !std::ranges::equal(body.subspan(8, own.size()), own);
      if (use(found)) return true;
    }
    if (kind != kData && kind != kDataFragment) continue;
    ByteCursor data(body, little);
    data.Take(2);
    const std::uint32_t to_inline_qos = data.Take(2);
    data.Take(4);
    DataFound found;
    found.writer = ByteCursor(data.Bytes(4), false).Take(4);
    if (kind == kData && to_inline_qos == kToInlineQos) {
      ReadBody(data, (flags & kInlineQos) != 0, found);
    }
    if (use(found)) return true;
  }
  return false;
}

/// Reads an announcement of the program that `program` identifies. Returns whether it is sound.
/// Raises `lease_s` to the time for which the program is to be remembered.
bool IsSound(const DataFound& data, std::span<const std::uint8_t> program, double& lease_s) {
  if (!data.whole) return false;
  ByteCursor head(data.body, false);
  const std::uint32_t encoding = head.Take(2);
  head.Take(2);
  if (encoding != kParametersLittle && encoding != kParametersBig) return false;
  const bool little = encoding == kParametersLittle;
  ByteCursor list(head.rest(), little);
  bool own = false;
  bool leased = false;
  bool announces = false;
  bool sound = true;
  const bool whole =
      ForEachParameter(list, [&](std::uint16_t parameter, std::span<const std::uint8_t> value) {
        ByteCursor number(value, little);
        if (parameter == kParticipantId) {
          own = value.size() >= program.size() &&
                std::ranges::equal(value.first(program.size()), program);
          sound = sound && own;
        } else if (parameter == kLeaseDuration) {
          const double seconds = number.Take(4);
          lease_s = std::max(lease_s, seconds + number.Take(4) / 4294967296.0);
          leased = true;
          sound = sound && number.good();
        } else if (parameter == kBuiltinEndpoints) {
          announces = (number.Take(4) & kAnnouncers) == kAnnouncers;
          sound = sound && announces;
        } else if (parameter == kVendorVersion) {
          number.Take(4);
          sound = sound && (number.Take(4) & kLeadsOthers) == 0;
        }
      });
  return whole && sound && own && (data.goodbye || (leased && announces));
}

}  // namespace

std::optional<Announcement> ReadAnnouncement(std::span<const std::uint8_t> packet) {
  Announcement announcement;
  const bool found = AnyData(packet, [&](const DataFound& data) {
    if (data.writer != kSpdpWriter || !data.whole) return false;
    const std::optional<AnnouncedSession> session = ReadParticipant(data.body);
    if (session) announcement.session = *session;
    return session.has_value();
  });
  if (!found) return std::nullopt;
  std::copy_n(packet.data() + kProgramAt, announcement.program.size(),
              announcement.program.begin());
  return announcement;
}

AnnouncedIn WhatIsAnnounced(std::span<const std::uint8_t> packet) {
  AnnouncedIn announced;
  Hash64 content;
  AnyData(packet, [&](const DataFound& data) {
    announced.unsound |= data.of_another;
    switch (data.writer) {
      case kSpdpWriter:
      case kSecureSpdpWriter:
        announced.unsound |=
            !IsSound(data, packet.subspan(kProgramAt, ProgramId{}.size()), announced.lease_s);
        if (data.goodbye) break;
        announced.program = true;
        content.AddBytes(data.body.data(), data.body.size());
        break;
      case kSedpTopics:
      case kSedpWriters:
      case kSedpReaders:
        ++announced.endpoints;
        break;
      default:
        break;
    }
    return false;
  });
  announced.content = content.value();
  return announced;
}

void ReplaceAnnouncedAddresses(std::span<std::uint8_t> packet, std::uint32_t address,
                               const std::function<bool(std::uint32_t announced)>& replaces) {
  AnyData(packet, [&](const DataFound& data) {
    if (data.writer != kSpdpWriter || !data.whole) return false;
    ByteCursor head(data.body, false);
    const std::uint32_t encoding = head.Take(2);
    head.Take(2);
    if (encoding != kParametersLittle && encoding != kParametersBig) return false;
    const bool little = encoding == kParametersLittle;
    ByteCursor list(head.rest(), little);
    ForEachParameter(list, [&](std::uint16_t parameter, std::span<const std::uint8_t> value) {
      const bool locates =
          parameter == kDefaultUnicastLocator || parameter == kMetatrafficUnicastLocator;
      if (!locates || value.size() < kLocatorBytes) return;
      if (ByteCursor(value, little).Take(4) != kUdp4Locator) return;
      const auto at = static_cast<std::size_t>(value.data() - packet.data()) + kLocatorAddressAt;
      std::uint32_t announced = 0;
      std::memcpy(&announced, &packet[at], sizeof announced);
      if (replaces(announced)) std::memcpy(&packet[at], &address, sizeof address);
    });
    return false;
  });
}

}  // namespace tandem
