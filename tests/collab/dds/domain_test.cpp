#include "collab/dds/domain.h"

#include <gmock/gmock.h>

namespace tandem {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Domain, TagsKeepSessionsApartWhateverTheirNames) {
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
}

TEST(Domain, OtherInterfacesFindPeersByMulticast) {
  DdsOptions options;
  options.session = "s";
  options.interface = "eth0";
  const std::string xml = DomainXml(options, true);
  EXPECT_THAT(xml, HasSubstr("<NetworkInterface name=\"eth0\"/>"));
  EXPECT_THAT(xml, HasSubstr("<AllowMulticast>true<"));
  EXPECT_THAT(xml, Not(HasSubstr("127.0.0.1")));
  EXPECT_THAT(xml, HasSubstr("<Class>Realtime<"));
}

TEST(Domain, OptionsOutOfRangeAreSaidInWords) {
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
