// Tandem's end of a link with a network device, without sockets and in a time of its own.
//
// | fault | test |
// |---|---|
// | short, long, foreign packet; another version | RefusesMalformedPackets |
// | forged code, each byte | RefusesAPacketWithAnyByteChanged |
// | our own packets, sent back | RefusesItsOwnPackets |
// | duplicate, older packet | RefusesRepeatedPackets |
// | packets of an earlier session, or of an earlier run of Tandem | RefusesAnEarlier… |
// | a hello that is played again | ReplayedHelloIsIgnored |
// | packets that were held up | RefusesDelayedPackets |
// | another address, with and without a key | OnlyAKeyedDeviceMayChangeItsAddress |
// | a second device; a device that can other things | AcceptsOneDeviceAtATime,
// ADeviceThatComesBack… | | numbers that are none | RefusesInvalidNumbers |
#include "app/device/drivers/network/session.h"

#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "app/device/tandem_device.h"
#include "engine/base/units.h"
#include "tests/app/device/drivers/network/far_end.h"

namespace tandem::testing {
namespace {

using net::Session;
using Refusal = Session::Refusal;

net::Key KeyOf(const char* text) {
  return net::Key(std::vector<std::uint8_t>(text, text + std::strlen(text)));
}

net::Address At(const char* text) {
  net::Address address;
  EXPECT_TRUE(net::ReadAddress(text, address));
  return address;
}

net::State StateAt(double x) {
  net::State state;
  state.valid = TANDEM_HAS_POSE;
  state.position[0] = x;
  return state;
}

/// A session and its time.
struct Tandem {
  explicit Tandem(net::Key key = {}, const char* secret = "a secret of this run")
      : session(std::move(key), KeyOf(secret), {}) {}
  Refusal Take(const Bytes& bytes, const net::Address& from) {
    Session::Taken taken = session.Take(bytes, from, now_ns);
    answer.clear();
    if (taken.answer) {
      answer.assign(taken.answer->bytes().begin(), taken.answer->bytes().end());
    }
    return taken.refusal;
  }
  Refusal Take(const Bytes& bytes) { return Take(bytes, here); }
  /// Greets a device, up to its first state.
  Refusal Greet(DeviceEnd& device) {
    const Refusal hello = Take(device.Hello(device_ns()));
    if (hello != Refusal::kNone) return hello;
    EXPECT_TRUE(device.Take(answer, device_ns()));
    return Take(device.State(device_ns(), StateAt(0)));
  }
  void GiveForce(DeviceEnd& device) {
    const net::PacketWriter packet = session.ForcePacket({}, session.sent_ns(), now_ns);
    EXPECT_TRUE(device.Take(packet.bytes(), device_ns()));
  }
  /// Returns the device's time, which is another one.
  std::int64_t device_ns() const { return now_ns - 987'654'321; }

  Session session;
  net::Address here = At("127.0.0.1:5000");
  std::int64_t now_ns = 1000 * kMs;
  Bytes answer;
};

const char* const kKey = "0123456789abcdef";

TEST(NetworkPacket, HasTheDocumentedBytes) {
  DeviceEnd device({}, 0x0102030405060708);
  device.header().host_session = 9;
  device.header().sequence = 0xFF;
  device.header().echo_ns = -2;
  net::State state = StateAt(1.0);  // 1.0 is 3F F0 00 …
  state.buttons = 2;
  const Bytes packet = device.State(0x11, state);
  ASSERT_EQ(packet.size(), 160U);
  EXPECT_EQ(std::string(packet.begin(), packet.begin() + 4), "TDMD");
  EXPECT_EQ(packet[4], 1);     // version
  EXPECT_EQ(packet[5], 2);     // kind
  EXPECT_EQ(packet[6], 160);   // length
  EXPECT_EQ(packet[8], 0x08);  // session, the lowest byte first
  EXPECT_EQ(packet[15], 0x01);
  EXPECT_EQ(packet[16], 9);
  EXPECT_EQ(packet[25], 1);  // sequence 0x100
  EXPECT_EQ(packet[32], 0x11);
  EXPECT_EQ(packet[40], 0xFE);
  EXPECT_EQ(packet[48], 1);  // valid
  EXPECT_EQ(packet[52], 2);  // buttons
  EXPECT_EQ(packet[62], 0xF0);
  EXPECT_EQ(packet[63], 0x3F);
  EXPECT_EQ(device.Hello(1).size(), 208U);
  EXPECT_EQ(DeviceEnd(KeyOf(kKey)).Hello(1).size(), 240U);
}

// RFC 4231, test case 2
TEST(NetworkKey, IsHmacSha256) {
  const std::string text = "what do ya want for nothing?";
  const net::Key::Code code =
      KeyOf("Jefe").CodeOf({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  EXPECT_EQ(code[0], 0x5b);
  EXPECT_EQ(code[1], 0xdc);
  EXPECT_EQ(code[30], 0x38);
  EXPECT_EQ(code[31], 0x43);
}

TEST(NetworkSession, BeginsWithAGreetingAndTakesStates) {
  for (const bool keyed : {false, true}) {
    Tandem tandem(keyed ? KeyOf(kKey) : net::Key());
    DeviceEnd device(keyed ? KeyOf(kKey) : net::Key());
    EXPECT_FALSE(tandem.session.alive(tandem.now_ns));
    ASSERT_EQ(tandem.Greet(device), Refusal::kNone);
    EXPECT_TRUE(tandem.session.alive(tandem.now_ns));
    EXPECT_EQ(tandem.session.hello(), SomeHello());
    tandem.now_ns += kMs;
    EXPECT_EQ(tandem.Take(device.State(tandem.device_ns(), StateAt(0.5))), Refusal::kNone);
    EXPECT_EQ(tandem.session.state().position[0], 0.5);
    EXPECT_EQ(tandem.session.state_ns() - tandem.session.echo_ns(), kMs);
  }
}

TEST(NetworkSession, RefusesMalformedPackets) {
  Tandem tandem;
  DeviceEnd device;
  ASSERT_EQ(tandem.Greet(device), Refusal::kNone);
  const Bytes sound = device.State(tandem.device_ns(), StateAt(1));
  for (std::size_t length = 0; length < sound.size(); ++length) {
    EXPECT_EQ(tandem.Take(Bytes(sound.begin(), sound.begin() + static_cast<long>(length))),
              Refusal::kForm);
  }
  Bytes longer = sound;
  longer.push_back(0);
  EXPECT_EQ(tandem.Take(longer), Refusal::kForm);
  longer.resize(net::kLongestBytes);
  EXPECT_EQ(tandem.Take(longer), Refusal::kForm);
  Bytes foreign = sound;
  foreign[0] = 'X';
  EXPECT_EQ(tandem.Take(foreign), Refusal::kForm);
  Bytes newer = sound;
  newer[4] = 2;
  EXPECT_EQ(tandem.Take(newer), Refusal::kVersion);
  EXPECT_NE(tandem.session.Refusals().find("refused"), std::string::npos);
  EXPECT_EQ(tandem.session.state().position[0], 0);
  EXPECT_EQ(tandem.Take(sound), Refusal::kNone);
}

TEST(NetworkSession, RefusesAPacketWithAnyByteChanged) {
  Tandem tandem(KeyOf(kKey));
  DeviceEnd device(KeyOf(kKey));
  ASSERT_EQ(tandem.Greet(device), Refusal::kNone);
  const Bytes sound = device.State(tandem.device_ns(), StateAt(1));
  for (std::size_t i = 0; i < sound.size(); ++i) {
    Bytes forged = sound;
    forged[i] ^= 1U;
    EXPECT_NE(tandem.Take(forged), Refusal::kNone) << i;
  }
  EXPECT_GT(tandem.session.refused(Refusal::kForged), 170U);
  // packets with another key, and without one
  DeviceEnd stranger(KeyOf("another key, 16 b"));
  EXPECT_EQ(tandem.Take(stranger.Hello(1)), Refusal::kForged);
  EXPECT_EQ(tandem.Take(DeviceEnd().Hello(1)), Refusal::kForm);
  EXPECT_EQ(tandem.session.state().position[0], 0);
  EXPECT_EQ(tandem.Take(sound), Refusal::kNone);
}

TEST(NetworkSession, RefusesItsOwnPackets) {
  Tandem tandem(KeyOf(kKey));
  DeviceEnd device(KeyOf(kKey));
  ASSERT_EQ(tandem.Take(device.Hello(1)), Refusal::kNone);
  EXPECT_EQ(tandem.Take(Bytes(tandem.answer)), Refusal::kForm);
  ASSERT_EQ(tandem.Greet(device), Refusal::kNone);
  for (const net::PacketWriter& own : {tandem.session.ForcePacket({}, 1, tandem.now_ns),
                                       tandem.session.EndPacket(tandem.now_ns)}) {
    EXPECT_EQ(tandem.Take(Bytes(own.bytes().begin(), own.bytes().end())), Refusal::kForm);
  }
  // and the device takes none of its own
  EXPECT_FALSE(device.Take(device.State(1, StateAt(0)), 1));
}

TEST(NetworkSession, RefusesRepeatedPackets) {
  Tandem tandem(KeyOf(kKey));
  DeviceEnd device(KeyOf(kKey));
  ASSERT_EQ(tandem.Greet(device), Refusal::kNone);
  const Bytes first = device.State(tandem.device_ns(), StateAt(1));
  const Bytes second = device.State(tandem.device_ns(), StateAt(2));
  EXPECT_EQ(tandem.Take(second), Refusal::kNone);
  EXPECT_EQ(tandem.Take(second), Refusal::kReplayed);
  EXPECT_EQ(tandem.Take(first), Refusal::kReplayed);
  EXPECT_EQ(tandem.session.state().position[0], 2);
}

TEST(NetworkSession, RefusesPacketsOfAnEarlierSession) {
  Tandem tandem(KeyOf(kKey));
  DeviceEnd device(KeyOf(kKey), 7);
  std::vector<Bytes> received{device.Hello(tandem.device_ns())};
  ASSERT_EQ(tandem.Take(received[0]), Refusal::kNone);
  ASSERT_TRUE(device.Take(tandem.answer, 0));
  for (int i = 0; i < 5; ++i) {
    received.push_back(device.State(tandem.device_ns(), StateAt(i)));
    ASSERT_EQ(tandem.Take(received.back()), Refusal::kNone);
  }
  received.push_back(device.State(tandem.device_ns(), StateAt(9)));  // held back, never seen
  ASSERT_EQ(tandem.Take(device.End(tandem.device_ns())), Refusal::kNone);
  // the whole conversation again, in order
  for (std::size_t i = 1; i < received.size(); ++i) {
    tandem.Take(received[0]);
    EXPECT_EQ(tandem.Take(received[i]), Refusal::kSession) << i;
  }
  EXPECT_FALSE(tandem.session.on());
  // the device itself comes back with another number
  DeviceEnd again(KeyOf(kKey), 8);
  ASSERT_EQ(tandem.Greet(again), Refusal::kNone);
  EXPECT_EQ(tandem.Take(received.back()), Refusal::kSession);
}

TEST(NetworkSession, RefusesPacketsOfAnEarlierRun) {
  DeviceEnd device(KeyOf(kKey));
  Tandem before(KeyOf(kKey), "the secret of a run");
  ASSERT_EQ(before.Greet(device), Refusal::kNone);
  const Bytes received = device.State(before.device_ns(), StateAt(3));
  Tandem now(KeyOf(kKey), "that of another run");
  DeviceEnd again(KeyOf(kKey));
  ASSERT_EQ(now.Take(again.Hello(now.device_ns())), Refusal::kNone);
  EXPECT_EQ(now.Take(received), Refusal::kSession);
  EXPECT_FALSE(now.session.on());
}

TEST(NetworkSession, ReplayedHelloIsIgnored) {
  Tandem tandem(KeyOf(kKey));
  DeviceEnd old(KeyOf(kKey), 5);
  const Bytes hello = old.Hello(tandem.device_ns());
  DeviceEnd device(KeyOf(kKey), 7);
  ASSERT_EQ(tandem.Take(device.Hello(tandem.device_ns())), Refusal::kNone);
  ASSERT_TRUE(device.Take(tandem.answer, 0));
  // while the device is being greeted, and after that
  for (int i = 0; i < 100; ++i) EXPECT_EQ(tandem.Take(hello), Refusal::kNone);
  EXPECT_LT(tandem.answer.size(), hello.size());  // our answers flood nobody
  EXPECT_FALSE(tandem.session.on());
  EXPECT_EQ(tandem.Take(device.State(tandem.device_ns(), StateAt(0))), Refusal::kNone);
  EXPECT_EQ(tandem.Take(hello), Refusal::kBusy);
  EXPECT_TRUE(tandem.answer.empty());
  EXPECT_EQ(tandem.session.sessions(), 1U);
}

TEST(NetworkSession, RefusesDelayedPackets) {
  Tandem tandem(KeyOf(kKey));
  DeviceEnd device(KeyOf(kKey));
  ASSERT_EQ(tandem.Greet(device), Refusal::kNone);
  const Bytes held = device.State(tandem.device_ns(), StateAt(1));
  tandem.now_ns += 101 * kMs;
  EXPECT_FALSE(tandem.session.alive(tandem.now_ns));
  EXPECT_EQ(tandem.Take(held), Refusal::kLate);
  // it goes on with the first state that follows from a force of now
  tandem.GiveForce(device);
  EXPECT_EQ(tandem.Take(device.State(tandem.device_ns(), StateAt(2))), Refusal::kNone);
  EXPECT_TRUE(tandem.session.alive(tandem.now_ns));
  // a packet that follows from one that we have not sent yet
  device.header().echo_ns = tandem.now_ns + kMs;
  EXPECT_EQ(tandem.Take(device.State(tandem.device_ns(), StateAt(3))), Refusal::kUnsound);
}

TEST(NetworkSession, OnlyAKeyedDeviceMayChangeItsAddress) {
  const net::Address elsewhere = At("127.0.0.1:5001");
  Tandem bare;
  DeviceEnd device;
  ASSERT_EQ(bare.Greet(device), Refusal::kNone);
  EXPECT_EQ(bare.Take(device.State(bare.device_ns(), StateAt(1)), elsewhere), Refusal::kAddress);
  EXPECT_EQ(bare.Take(device.End(bare.device_ns()), elsewhere), Refusal::kAddress);
  EXPECT_TRUE(bare.session.address() == bare.here);
  Tandem tandem(KeyOf(kKey));
  DeviceEnd keyed(KeyOf(kKey));
  ASSERT_EQ(tandem.Greet(keyed), Refusal::kNone);
  const Bytes old = keyed.State(tandem.device_ns(), StateAt(1));
  EXPECT_EQ(tandem.Take(keyed.State(tandem.device_ns(), StateAt(2)), elsewhere), Refusal::kNone);
  EXPECT_TRUE(tandem.session.address() == elsewhere);
  EXPECT_EQ(tandem.Take(old, At("127.0.0.1:5002")), Refusal::kReplayed);
  EXPECT_TRUE(tandem.session.address() == elsewhere);  // an old packet moves nothing
}

TEST(NetworkSession, AcceptsOneDeviceAtATime) {
  Tandem tandem;
  DeviceEnd first({}, 1), second({}, 2);
  ASSERT_EQ(tandem.Take(second.Hello(1), At("127.0.0.1:6000")), Refusal::kNone);
  ASSERT_TRUE(second.Take(tandem.answer, 1));
  ASSERT_EQ(tandem.Greet(first), Refusal::kNone);
  EXPECT_EQ(tandem.Take(second.State(2, StateAt(5)), At("127.0.0.1:6000")), Refusal::kSession);
  EXPECT_EQ(tandem.Take(second.Hello(3), At("127.0.0.1:6000")), Refusal::kBusy);
  EXPECT_NE(tandem.session.state().position[0], 5);
  // once the first device is silent
  tandem.now_ns += 101 * kMs;
  EXPECT_EQ(tandem.Greet(second), Refusal::kNone);
}

TEST(NetworkSession, ReturningDeviceKeepsItsCapabilities) {
  Tandem tandem;
  DeviceEnd device;
  ASSERT_EQ(tandem.Greet(device), Refusal::kNone);
  tandem.now_ns += 200 * kMs;
  net::Hello stronger = SomeHello();
  stronger.peak_force = 20;
  DeviceEnd again({}, 8);
  EXPECT_EQ(tandem.Take(again.Hello(tandem.device_ns(), stronger)), Refusal::kOther);
  EXPECT_EQ(tandem.Greet(again), Refusal::kNone);
  EXPECT_EQ(tandem.session.sessions(), 2U);
}

TEST(NetworkSession, RefusesInvalidNumbers) {
  Tandem tandem;
  DeviceEnd device;
  ASSERT_EQ(tandem.Greet(device), Refusal::kNone);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  std::vector<net::State> unsound(6, StateAt(1));
  unsound[0].position[2] = kNan;
  unsound[1].position[0] = 1e9;
  unsound[2].orientation = {0, 0, 0, 0};
  unsound[3].orientation[1] = kNan;
  unsound[4].valid |= TANDEM_HAS_VELOCITY;
  unsound[4].velocity[0] = std::numeric_limits<double>::infinity();
  unsound[5].valid = 0;
  for (const net::State& state : unsound) {
    EXPECT_EQ(tandem.Take(device.State(tandem.device_ns(), state)), Refusal::kUnsound);
  }
  EXPECT_EQ(tandem.session.state().position[0], 0);
  net::Hello weird = SomeHello();
  weird.peak_force = kNan;
  EXPECT_EQ(Tandem().Take(DeviceEnd().Hello(1, weird)), Refusal::kUnsound);
  weird = SomeHello();
  weird.freedoms_out = 7;
  EXPECT_EQ(Tandem().Take(DeviceEnd().Hello(1, weird)), Refusal::kUnsound);
  weird = SomeHello();
  weird.stiffness = -1;
  EXPECT_EQ(Tandem().Take(DeviceEnd().Hello(1, weird)), Refusal::kUnsound);
}

}  // namespace
}  // namespace tandem::testing
