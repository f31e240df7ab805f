#include "collab/dds/transport/packet_filter.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/base/units.h"

namespace tandem {
namespace {

using RawPacket = std::vector<std::uint8_t>;

constexpr std::uint32_t kHere = 0x0100007F;

void Put(RawPacket& packet, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) packet.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

/// Returns a packet of a program, with nothing in it (RTPS 2.5, section 9.4.4).
RawPacket Empty(std::uint64_t program) {
  RawPacket packet{'R', 'T', 'P', 'S', 2, 5, 1, 16};
  Put(packet, program, 8);
  Put(packet, 0x01020304, 4);
  return packet;
}

/// Puts a DATA submessage of a writer behind what is there. `to_inline_qos`: offset at which sound
/// ones begin.
void PutData(RawPacket& packet, std::uint32_t writer, const RawPacket& content,
             std::uint16_t to_inline_qos = 16) {
  packet.insert(packet.end(), {0x15, 0x05});  // DATA, little endian, with data
  Put(packet, 20 + content.size(), 2);
  Put(packet, 0, 2);
  Put(packet, to_inline_qos, 2);
  Put(packet, 0, 4);  // reader
  for (int i = 3; i >= 0; --i) packet.push_back(static_cast<std::uint8_t>(writer >> (8 * i)));
  Put(packet, 1, 8);  // sequence number
  packet.insert(packet.end(), content.begin(), content.end());
}

RawPacket Data(std::uint64_t program, std::uint32_t writer, const RawPacket& content) {
  RawPacket packet = Empty(program);
  PutData(packet, writer, content);
  return packet;
}

/// Returns what a program announces of itself (SPDP). 0 leaves the lease, or the announcers of its
/// endpoints, out.
RawPacket Terms(std::uint64_t program, std::uint32_t lease_s, std::uint32_t announcers = 0xC3F) {
  RawPacket list{0, 3, 0, 0};  // parameters, little endian
  Put(list, 0x0050, 2);        // PID_PARTICIPANT_GUID
  Put(list, 16, 2);
  Put(list, program, 8);
  Put(list, 0x01020304, 4);
  Put(list, 0xC1010000, 4);
  if (announcers != 0) {
    Put(list, 0x0058, 2);  // PID_BUILTIN_ENDPOINT_SET
    Put(list, 4, 2);
    Put(list, announcers, 4);
  }
  if (lease_s != 0) {
    Put(list, 0x0002, 2);  // PID_PARTICIPANT_LEASE_DURATION
    Put(list, 8, 2);
    Put(list, lease_s, 4);
    Put(list, 0, 4);
  }
  Put(list, 0x0001, 2);  // PID_SENTINEL
  Put(list, 0, 2);
  return list;
}

constexpr std::uint32_t kSpdpWriterId = 0x000100C2;

RawPacket Announced(std::uint64_t program, std::uint32_t lease_s = 2) {
  return Data(program, kSpdpWriterId, Terms(program, lease_s));
}

TEST(PacketFilter, SessionPacketsPass) {
  PacketFilter filter(1);
  for (std::int64_t ms = 1; ms < 10'000; ++ms) {
    for (std::uint64_t program = 1; program <= 20; ++program) {
      ASSERT_EQ(filter.Judge(Empty(program), kHere, ms * kMs), PacketDrop::kNone);
      if (ms % 650 != 0) continue;
      ASSERT_EQ(filter.Judge(Announced(program), kHere, ms * kMs), PacketDrop::kNone);
    }
  }
}

TEST(PacketFilter, NonDdsPacketsAreDropped) {
  PacketFilter filter(1);
  EXPECT_EQ(filter.Judge({}, kHere, kMs), PacketDrop::kNotRtps);
  EXPECT_EQ(filter.Judge(RawPacket(100, 'x'), kHere, kMs), PacketDrop::kNotRtps);
  const RawPacket good = Empty(1);
  EXPECT_EQ(filter.Judge(std::span(good).first(19), kHere, kMs), PacketDrop::kNotRtps);
}

TEST(PacketFilter, ForgedProgramsDoNotReachDds) {
  PacketFilter filter(1);
  std::int64_t now_ns = kMs;
  ASSERT_EQ(filter.Judge(Announced(7), kHere, now_ns), PacketDrop::kNone);
  std::int64_t passed = 0;
  // 2,000 a second
  for (std::uint64_t program = 1000; program < 101'000; ++program) {
    now_ns += kMs / 2;
    if (filter.Judge(Announced(program), kHere, now_ns) == PacketDrop::kNone) {
      ++passed;
    }
    // known programs go on being heard
    ASSERT_EQ(filter.Judge(Announced(7), kHere, now_ns), PacketDrop::kNone);
  }
  EXPECT_LE(passed, PacketFilter::kNewAtOnce + 50 * PacketFilter::kNewPerSecond + 1);
  EXPECT_GT(passed, 0);
}

TEST(PacketFilter, FloodFromOneAddressDoesNotBlockAnother) {
  PacketFilter filter(1);
  std::int64_t now_ns = kMs;
  for (std::uint64_t program = 1000; program < 11'000; ++program) {
    now_ns += kMs / 2;
    filter.Judge(Announced(program), kHere, now_ns);
  }
  EXPECT_EQ(filter.Judge(Announced(7), kHere + 256, now_ns), PacketDrop::kNone);
}

// 51 packets a second could keep all places taken.
TEST(PacketFilter, HourOfNewProgramsFromOneAddressDoesNotBlockAnother) {
  PacketFilter filter(1);
  std::int64_t now_ns = kMs;
  std::uint64_t newest = 1000;
  for (int second = 0; second < 3600; ++second) {
    now_ns += 1000 * kMs;
    newest += 2;
    for (std::uint64_t program = newest - std::min<std::uint64_t>(newest - 1000, 1500);
         program < newest && second % 10 == 0; ++program) {
      filter.Judge(Empty(program), kHere, now_ns);  // keeps its place
    }
    filter.Judge(Empty(newest), kHere, now_ns);
  }
  for (std::uint64_t program = 1; program <= 16; ++program) {
    EXPECT_EQ(filter.Judge(Announced(program), kHere + 256, now_ns), PacketDrop::kNone) << program;
  }
}

TEST(PacketFilter, FullTableEvictsFromTheLargestAddress) {
  PacketFilter filter(1);
  constexpr std::uint32_t kFrom = 20;  // addresses
  for (std::uint32_t from = 1; from <= kFrom; ++from) {
    for (std::uint64_t program = 0; program < 128; ++program) {
      filter.Judge(Empty(1000 * from + program), kHere + 256 * from, kMs);
    }
  }
  for (std::uint64_t program = 1; program <= 16; ++program) {
    EXPECT_EQ(filter.Judge(Announced(program), kHere, 2 * kMs), PacketDrop::kNone);
    EXPECT_EQ(filter.Judge(Announced(program), kHere, 3 * kMs), PacketDrop::kNone);
  }
}

TEST(PacketFilter, ProgramAnnouncesOnlyItself) {
  PacketFilter filter(1);
  EXPECT_EQ(filter.Judge(Data(7, kSpdpWriterId, Terms(8, 2)), kHere, kMs), PacketDrop::kForged);
  RawPacket both = Announced(7);
  PutData(both, kSpdpWriterId, Terms(8, 2));
  EXPECT_EQ(filter.Judge(both, kHere, kMs), PacketDrop::kForged);
}

// DDS would remember a program without a lease for 100 s, and one that announces no endpoints for
// as long as any other.
TEST(PacketFilter, AnnouncementNeedsALeaseAndEndpoints) {
  PacketFilter filter(1);
  const auto judged = [&](const RawPacket& terms) {
    return filter.Judge(Data(7, kSpdpWriterId, terms), kHere, kMs);
  };
  EXPECT_EQ(judged(Terms(7, 2)), PacketDrop::kNone);
  EXPECT_EQ(judged(Terms(7, 0)), PacketDrop::kForged);
  EXPECT_EQ(judged(Terms(7, 2, 0)), PacketDrop::kForged);
  EXPECT_EQ(judged(Terms(7, 2, 0xC2F)), PacketDrop::kForged);
  EXPECT_EQ(judged({}), PacketDrop::kForged);
}

// DDS takes what follows for the named program's, and keeps that program for as long as it comes.
TEST(PacketFilter, ProgramSpeaksOnlyForItself) {
  const auto speaking_for = [](std::uint64_t program) {
    RawPacket packet = Empty(7);
    packet.insert(packet.end(), {0x0C, 0x01});  // INFO_SRC, little endian
    Put(packet, 20, 2);
    Put(packet, 0, 4);
    packet.insert(packet.end(), {2, 5, 1, 16});
    Put(packet, program, 8);
    Put(packet, 0x01020304, 4);
    PutData(packet, 0x000003C2, {1, 2, 3, 4});
    return packet;
  };
  PacketFilter filter(1);
  EXPECT_EQ(filter.Judge(speaking_for(7), kHere, kMs), PacketDrop::kNone);
  EXPECT_EQ(filter.Judge(speaking_for(8), kHere, kMs), PacketDrop::kForged);
  RawPacket cut = speaking_for(8);
  cut.resize(20 + 4 + 12);
  cut[22] = 12;
  EXPECT_EQ(filter.Judge(cut, kHere, kMs), PacketDrop::kForged);
}

// DDS would give a program on which others depend the say over their leases and ends.
TEST(PacketFilter, NoProgramLeadsOthers) {
  const auto with_flags = [](std::uint32_t flags) {
    RawPacket terms = Terms(7, 2);
    terms.resize(terms.size() - 4);
    Put(terms, 0x8007, 2);  // PID_ADLINK_PARTICIPANT_VERSION_INFO
    Put(terms, 28, 2);
    Put(terms, 0, 4);
    Put(terms, flags, 4);
    for (int i = 0; i < 5; ++i) Put(terms, 0, 4);
    Put(terms, 0x0001, 2);
    Put(terms, 0, 2);
    return Data(7, kSpdpWriterId, terms);
  };
  PacketFilter filter(1);
  EXPECT_EQ(filter.Judge(with_flags(0x2C), kHere, kMs), PacketDrop::kNone);
  EXPECT_EQ(filter.Judge(with_flags(0x3C), kHere, kMs), PacketDrop::kForged);
}

TEST(PacketFilter, GoodbyeNeedsNeitherLeaseNorEndpoints) {
  PacketFilter filter(1);
  RawPacket goodbye = Empty(7);
  RawPacket content;
  Put(content, 0x0071, 2);  // PID_STATUS_INFO: disposed of, unregistered
  Put(content, 4, 2);
  Put(content, 0x03000000, 4);
  Put(content, 0x0001, 2);
  Put(content, 0, 2);
  const RawPacket terms = Terms(7, 0, 0);
  content.insert(content.end(), terms.begin(), terms.end());
  PutData(goodbye, kSpdpWriterId, content);
  goodbye[21] = 0x0B;  // with inline QoS, and a key
  EXPECT_EQ(filter.Judge(goodbye, kHere, kMs), PacketDrop::kNone);
  goodbye[20 + 4 + 20 + 4 + 3] = 0;  // the key is none
  EXPECT_EQ(filter.Judge(goodbye, kHere, kMs), PacketDrop::kForged);
}

TEST(PacketFilter, EmptySubmessageHidesNothing) {
  for (const std::uint8_t kind : {std::uint8_t{0x01}, std::uint8_t{0x09}}) {  // PAD, INFO_TS
    PacketFilter filter(1);
    RawPacket packet = Empty(7);
    packet.insert(packet.end(), {kind, 0x03, 0, 0});
    RawPacket endless = packet;
    PutData(packet, kSpdpWriterId, Terms(7, 2));
    PutData(endless, kSpdpWriterId, Terms(7, 0x7FFFFFFF));
    EXPECT_EQ(filter.Judge(packet, kHere, kMs), PacketDrop::kNone) << int{kind};
    EXPECT_EQ(filter.Judge(endless, kHere, kMs), PacketDrop::kForged) << int{kind};
  }
}

TEST(PacketFilter, SecureAnnouncerFollowsTheSameRules) {
  PacketFilter filter(1);
  EXPECT_EQ(filter.Judge(Data(7, 0xFF0101C2, Terms(7, 2)), kHere, kMs), PacketDrop::kNone);
  EXPECT_EQ(filter.Judge(Data(7, 0xFF0101C2, Terms(8, 2)), kHere, kMs), PacketDrop::kForged);
}

TEST(PacketFilter, AnnouncementNeedsTheUsualLayout) {
  PacketFilter filter(1);
  for (const unsigned to_inline_qos : {0U, 4U, 8U, 12U, 20U, 0xFFFFU}) {
    RawPacket packet = Empty(7);
    PutData(packet, kSpdpWriterId, Terms(7, 2), static_cast<std::uint16_t>(to_inline_qos));
    EXPECT_EQ(filter.Judge(packet, kHere, kMs), PacketDrop::kForged) << to_inline_qos;
  }
}

TEST(PacketFilter, FragmentedOrPermanentAnnouncementsAreDropped) {
  PacketFilter filter(1);
  EXPECT_EQ(filter.Judge(Announced(7), kHere, kMs), PacketDrop::kNone);
  EXPECT_EQ(filter.Judge(Announced(7, 0x7FFFFFFF), kHere, kMs), PacketDrop::kForged);
  // in pieces, which hide what they are
  RawPacket piece = Announced(7);
  piece[20] = 0x16;
  EXPECT_EQ(filter.Judge(piece, kHere, kMs), PacketDrop::kForged);
}

TEST(PacketFilter, ForgedIdFromAnotherAddressDoesNotHarmItsOwner) {
  PacketFilter filter(1);
  for (int i = 0; i < 200'000; ++i) filter.Judge(Empty(7), kHere + 256, kMs);
  EXPECT_EQ(filter.Judge(Empty(7), kHere + 256, kMs), PacketDrop::kFlood);
  EXPECT_EQ(filter.Judge(Empty(7), kHere, kMs), PacketDrop::kNone);
}

TEST(PacketFilter, AnnouncedEndpointsAreBounded) {
  for (const std::uint32_t writer : {0x000002C2U, 0x000003C2U, 0x000004C2U}) {
    PacketFilter filter(1);
    std::int64_t passed = 0;
    for (int i = 0; i < 100'000; ++i) {
      const PacketDrop drop = filter.Judge(Data(7, writer, RawPacket(64, 0)), kHere, kMs);
      if (drop == PacketDrop::kNone) {
        ++passed;
      } else {
        ASSERT_EQ(drop, PacketDrop::kEndpoints);
      }
    }
    EXPECT_LE(passed, PacketFilter::kEndpointsAtOnce + 1);
  }
}

TEST(PacketFilter, SilentSenderIsForgotten) {
  PacketFilter filter(1);
  std::int64_t now_ns = kMs;
  std::size_t passed = 0;
  // over a day there is room for many more than at once
  for (std::uint64_t program = 1; program <= 20'000; ++program) {
    now_ns += 4'000 * kMs;
    if (filter.Judge(Empty(program), kHere, now_ns) == PacketDrop::kNone) ++passed;
  }
  EXPECT_EQ(passed, 20'000U);
}

}  // namespace
}  // namespace tandem
