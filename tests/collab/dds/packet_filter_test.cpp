#include "collab/dds/packet_filter.h"

#include <string>

#include <gtest/gtest.h>

namespace tandem {
namespace {

using RawPacket = std::vector<std::uint8_t>;

constexpr std::int64_t kFilterMsNs = 1'000'000;
constexpr std::uint32_t kHere = 0x0100007F;

void Put(RawPacket& packet, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) packet.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

/// A packet of a program, with nothing in it (RTPS 2.5, section 9.4.4).
RawPacket Empty(std::uint64_t program) {
  RawPacket packet{'R', 'T', 'P', 'S', 2, 5, 1, 16};
  Put(packet, program, 8);
  Put(packet, 0x01020304, 4);
  return packet;
}

/// A DATA submessage of a writer in it.
RawPacket Data(std::uint64_t program, std::uint32_t writer, const RawPacket& content) {
  RawPacket packet = Empty(program);
  packet.insert(packet.end(), {0x15, 0x05});  // DATA, little endian, with data
  Put(packet, 20 + content.size(), 2);
  Put(packet, 0, 2);
  Put(packet, 16, 2);  // from here to the data
  Put(packet, 0, 4);   // reader
  for (int i = 3; i >= 0; --i) packet.push_back(static_cast<std::uint8_t>(writer >> (8 * i)));
  Put(packet, 1, 8);  // sequence number
  packet.insert(packet.end(), content.begin(), content.end());
  return packet;
}

/// An announcement (SPDP) by `sender` of `program`, with a lease.
RawPacket Announced(std::uint64_t sender, std::uint64_t program, std::uint32_t lease_s) {
  RawPacket list{0, 3, 0, 0};  // parameters, little endian
  Put(list, 0x0050, 2);     // PID_PARTICIPANT_GUID
  Put(list, 16, 2);
  Put(list, program, 8);
  Put(list, 0x01020304, 4);
  Put(list, 0xC1010000, 4);
  Put(list, 0x0002, 2);  // PID_PARTICIPANT_LEASE_DURATION
  Put(list, 8, 2);
  Put(list, lease_s, 4);
  Put(list, 0, 4);
  Put(list, 0x0001, 2);  // PID_SENTINEL
  Put(list, 0, 2);
  return Data(sender, 0x000100C2, list);
}

TEST(PacketFilter, ASessionsPacketsPass) {
  PacketFilter filter(1);
  for (std::int64_t ms = 1; ms < 10'000; ++ms) {
    for (std::uint64_t program = 1; program <= 20; ++program) {
      ASSERT_EQ(filter.Judge(Empty(program), kHere, ms * kFilterMsNs), PacketDrop::kNone);
      if (ms % 650 != 0) continue;
      ASSERT_EQ(filter.Judge(Announced(program, program, 2), kHere, ms * kFilterMsNs),
                PacketDrop::kNone);
    }
  }
}

TEST(PacketFilter, WhatIsNoPacketOfDdsIsDropped) {
  PacketFilter filter(1);
  EXPECT_EQ(filter.Judge({}, kHere, kFilterMsNs), PacketDrop::kNotRtps);
  EXPECT_EQ(filter.Judge(RawPacket(100, 'x'), kHere, kFilterMsNs), PacketDrop::kNotRtps);
  const RawPacket good = Empty(1);
  EXPECT_EQ(filter.Judge(std::span(good).first(19), kHere, kFilterMsNs), PacketDrop::kNotRtps);
}

TEST(PacketFilter, AHundredThousandForgedProgramsAreNotSeenByDds) {
  PacketFilter filter(1);
  std::int64_t now_ns = kFilterMsNs;
  ASSERT_EQ(filter.Judge(Announced(7, 7, 2), kHere, now_ns), PacketDrop::kNone);
  std::int64_t passed = 0;
  // 2,000 a second
  for (std::uint64_t program = 1000; program < 101'000; ++program) {
    now_ns += kFilterMsNs / 2;
    if (filter.Judge(Announced(program, program, 2), kHere, now_ns) == PacketDrop::kNone) {
      ++passed;
    }
    // those who are known go on being heard
    ASSERT_EQ(filter.Judge(Announced(7, 7, 2), kHere, now_ns), PacketDrop::kNone);
  }
  EXPECT_LE(passed, PacketFilter::kNewAtOnce + 50 * PacketFilter::kNewPerSecond + 1);
  EXPECT_GT(passed, 0);
}

TEST(PacketFilter, AFloodOfOneAddressKeepsNobodyOfAnotherOut) {
  PacketFilter filter(1);
  std::int64_t now_ns = kFilterMsNs;
  for (std::uint64_t program = 1000; program < 11'000; ++program) {
    now_ns += kFilterMsNs / 2;
    filter.Judge(Announced(program, program, 2), kHere, now_ns);
  }
  EXPECT_EQ(filter.Judge(Announced(7, 7, 2), kHere + 256, now_ns), PacketDrop::kNone);
}

TEST(PacketFilter, OneThatAnnouncesEverNewOnesHasNoMoreThanThey) {
  PacketFilter filter(1);
  std::int64_t passed = 0;
  for (std::uint64_t program = 1000; program < 2000; ++program) {
    const PacketDrop drop = filter.Judge(Announced(7, program, 2), kHere, kFilterMsNs);
    if (drop == PacketDrop::kNone) ++passed;
  }
  EXPECT_LE(passed, PacketFilter::kNewAtOnce);
  EXPECT_GT(passed, 0);
}

TEST(PacketFilter, AnnouncementsInPiecesOrForEverAreForged) {
  PacketFilter filter(1);
  EXPECT_EQ(filter.Judge(Announced(7, 7, 2), kHere, kFilterMsNs), PacketDrop::kNone);
  EXPECT_EQ(filter.Judge(Announced(7, 7, 0x7FFFFFFF), kHere, kFilterMsNs), PacketDrop::kForged);
  // in pieces, which hide what they are
  RawPacket piece = Announced(7, 7, 2);
  piece[20] = 0x16;
  EXPECT_EQ(filter.Judge(piece, kHere, kFilterMsNs), PacketDrop::kForged);
}

TEST(PacketFilter, AnothersIdFromElsewhereTakesNothingFromIt) {
  PacketFilter filter(1);
  for (int i = 0; i < 200'000; ++i) filter.Judge(Empty(7), kHere + 256, kFilterMsNs);
  EXPECT_EQ(filter.Judge(Empty(7), kHere + 256, kFilterMsNs), PacketDrop::kFlood);
  EXPECT_EQ(filter.Judge(Empty(7), kHere, kFilterMsNs), PacketDrop::kNone);
}

TEST(PacketFilter, AProgramAnnouncesNoMoreEndpointsThanItCanHave) {
  PacketFilter filter(1);
  std::int64_t passed = 0;
  for (int i = 0; i < 100'000; ++i) {
    const PacketDrop drop = filter.Judge(Data(7, 0x000003C2, RawPacket(64, 0)), kHere, kFilterMsNs);
    if (drop == PacketDrop::kNone) {
      ++passed;
    } else {
      ASSERT_EQ(drop, PacketDrop::kEndpoints);
    }
  }
  EXPECT_LE(passed, PacketFilter::kEndpointsAtOnce + 1);
}

TEST(PacketFilter, ASilentSenderIsForgotten) {
  PacketFilter filter(1);
  std::int64_t now_ns = kFilterMsNs;
  std::size_t passed = 0;
  // over a day there is room for many more than at once
  for (std::uint64_t program = 1; program <= 20'000; ++program) {
    now_ns += 4'000 * kFilterMsNs;
    if (filter.Judge(Empty(program), kHere, now_ns) == PacketDrop::kNone) ++passed;
  }
  EXPECT_EQ(passed, 20'000U);
}

}  // namespace
}  // namespace tandem
