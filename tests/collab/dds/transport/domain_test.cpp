#include "collab/dds/transport/domain.h"

#include <dds/ddsi/ddsi_xt_typeinfo.h>
#include <gmock/gmock.h>

#include "collab/dds/cyclone/qos.h"
#include "collab/dds/transport/receive_thread.h"

extern "C" bool ddsi_typeinfo_valid(const ddsi_typeinfo* info);

namespace tandem {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Domain, TagsIsolateSessionsOfAnyName) {
  EXPECT_EQ(DiscoveryTag("demo-12_a.b"), "tandem/demo-12_a.b");
  EXPECT_EQ(DiscoveryTag("a b</Tag>${HOME}\\"), "tandem/a%20b%3C%2FTag%3E%24%7BHOME%7D%5C");
  EXPECT_NE(DiscoveryTag("a%20b"), DiscoveryTag("a b"));
  EXPECT_NE(DiscoveryTag(" a"), DiscoveryTag("a"));
}

TEST(Domain, LoopbackIsQuiet) {
  DdsOptions options;
  options.session = "s";
  options.interface = "lo";
  const std::string xml = DomainXml(options, false);
  EXPECT_THAT(xml, HasSubstr("<AllowMulticast>false<"));
  EXPECT_THAT(xml, HasSubstr("<Peer address=\"127.0.0.1\"/>"));
  EXPECT_THAT(xml, Not(HasSubstr("Realtime")));
  EXPECT_THAT(xml, HasSubstr("<MultipleReceiveThreads>true<"));
  EXPECT_STREQ(ReceiveThreadOf(options), "recvUC");
}

TEST(Domain, OtherInterfacesFindPeersByMulticast) {
  DdsOptions options;
  options.session = "s";
  options.interface = "eth0";
  const std::string xml = DomainXml(options, true);
  // Cyclone sees one network, which DomainNetworks bounds to that interface
  EXPECT_THAT(xml, Not(HasSubstr("<NetworkInterface")));
  EXPECT_THAT(xml, HasSubstr("<AllowMulticast>true<"));
  EXPECT_THAT(xml, Not(HasSubstr("127.0.0.1")));
  EXPECT_THAT(xml, HasSubstr("<Class>Realtime<"));
  EXPECT_THAT(xml, HasSubstr("<MultipleReceiveThreads>false<"));
  EXPECT_STREQ(ReceiveThreadOf(options), "recv");
}

TEST(Domain, NamedPeersReplaceMulticast) {
  DdsOptions options;
  options.session = "s";
  options.interface = "eth0";
  options.peers = {"192.0.2.7", "192.0.2.8:7500"};
  options.external_address = "203.0.113.1";
  const std::string xml = DomainXml(options, false);
  EXPECT_THAT(xml, HasSubstr("<AllowMulticast>false<"));
  EXPECT_THAT(xml, HasSubstr("<Peer address=\"192.0.2.7\"/><Peer address=\"192.0.2.8:7500\"/>"));
  EXPECT_THAT(xml, HasSubstr("<ExternalNetworkAddress>203.0.113.1<"));
  EXPECT_THAT(xml, HasSubstr("<MaxMessageSize>1400 B<"));
}

TEST(Domain, OwnPortIsAssumedForNamedPeers) {
  DdsOptions options;
  options.session = "s";
  options.peers = {"192.0.2.7", "192.0.2.8:7500"};
  options.port = 9000;
  const std::string xml = DomainXml(options, false);
  EXPECT_THAT(xml, HasSubstr("<Base>9000</Base>"));
  EXPECT_THAT(xml, HasSubstr("<ParticipantIndex>0<"));
  EXPECT_THAT(xml, HasSubstr("192.0.2.7:9000\"/><Peer address=\"192.0.2.8:7500\""));
}

// Announcements come often enough that a peer is back within a second of a cut's end, and not so
// often that they would stand for a sign of life.
TEST(Domain, AnnouncesItselfOftenExceptOnTheLoopback) {
  DdsOptions options;
  options.session = "s";
  EXPECT_THAT(DomainXml(options, false), HasSubstr("<SPDPInterval>650 ms<"));
  EXPECT_LT(kLivelinessLeaseNs, 650'000'000);
  options.interface = "lo";
  EXPECT_THAT(DomainXml(options, false), Not(HasSubstr("SPDPInterval")));
}

// Cyclone 0.10.2 by itself aborts at the second one.
TEST(Domain, UnknownTypeKindIsRefused) {
  const auto valid = [](std::uint8_t minimal, std::uint8_t complete) {
    DDS_XTypes_TypeInformation info{};
    info.minimal.typeid_with_size.type_id._d = minimal;
    info.minimal.typeid_with_size.typeobject_serialized_size = 100;
    info.minimal.dependent_typeid_count = -1;
    info.complete.typeid_with_size.type_id._d = complete;
    info.complete.typeid_with_size.typeobject_serialized_size = 100;
    info.complete.dependent_typeid_count = -1;
    return ddsi_typeinfo_valid(reinterpret_cast<const ddsi_typeinfo*>(&info));
  };
  EXPECT_TRUE(valid(DDS_XTypes_EK_MINIMAL, DDS_XTypes_EK_COMPLETE));
  EXPECT_FALSE(valid(DDS_XTypes_EK_MINIMAL, 0x42));
  EXPECT_FALSE(valid(0x42, DDS_XTypes_EK_COMPLETE));
  EXPECT_FALSE(valid(0, 0));
}

TEST(Domain, PeerAddressesAreHostAndPort) {
  EXPECT_EQ(ParsePeerAddress("anna.example")->host, "anna.example");
  EXPECT_EQ(ParsePeerAddress("anna.example")->port, 0);
  EXPECT_EQ(ParsePeerAddress("10.0.0.1:7410")->port, 7410);
  for (const char* bad : {"", ":7410", "a:", "a:0", "a:65536", "a:1x", "a b", "::1"}) {
    EXPECT_FALSE(ParsePeerAddress(bad).has_value()) << bad;
  }
}

TEST(Domain, UnusableAddressesAreReported) {
  DdsOptions options;
  options.session = "s";
  options.peers = {"no-such-host.invalid"};
  EXPECT_THAT(CheckOptions(options)->what, HasSubstr("no-such-host.invalid"));
  options.peers.clear();
  options.external_address = "router";
  EXPECT_THAT(CheckOptions(options)->what, HasSubstr("--external-address"));
  options.external_address.clear();
  options.interface = "no-such-one";
  EXPECT_THAT(CheckOptions(options)->what, HasSubstr("usable: "));
}

TEST(Domain, OptionsOutOfRangeAreReported) {
  DdsOptions options;
  EXPECT_THAT(CreateDomain(options).error().what, HasSubstr("name"));
  options.session = std::string(200, 's');
  EXPECT_THAT(CreateDomain(options).error().what, HasSubstr("longer"));
  options.session = "s";
  options.domain = 231;
  EXPECT_THAT(CreateDomain(options).error().what, HasSubstr("231"));
}

}  // namespace
}  // namespace tandem
