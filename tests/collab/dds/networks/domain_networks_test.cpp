#include "collab/dds/networks/domain_networks.h"

#include <algorithm>
#include <string>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include "collab/dds/networks/usable_networks.h"

namespace tandem {
namespace {

std::uint32_t Address(const char* text) {
  return inet_addr(text);
}

NetworkTable TableOf(std::initializer_list<NetworkTable::Row> rows) {
  NetworkTable table;
  for (const NetworkTable::Row& row : rows) table.rows[table.count++] = row;
  return table;
}

TEST(DomainNetworks, LoopbackHearsLoopbackAlone) {
  const DomainNetworks networks("lo");
  EXPECT_TRUE(networks.Hears({.from = Address("127.0.0.1")}));
  EXPECT_TRUE(networks.Hears({.from = Address("127.3.2.1")}));
  for (const char* const other : {"10.0.0.1", "128.0.0.1", "126.255.255.255", "0.0.0.0"}) {
    EXPECT_FALSE(networks.Hears({.from = Address(other)})) << other;
  }
}

TEST(DomainNetworks, OneInterfaceHearsItselfAndThisMachine) {
  const unsigned lo = if_nametoindex("lo");
  const DomainNetworks networks("no-such-one");
  EXPECT_TRUE(networks.Hears({.from = Address("10.0.0.1"), .interface = lo}));
  EXPECT_FALSE(networks.Hears({.from = Address("10.0.0.1"), .interface = lo + 1000}));
  const DomainNetworks all("");
  EXPECT_TRUE(all.Hears({.from = Address("10.0.0.1"), .interface = lo + 1000}));
}

TEST(DomainNetworks, SocketOfLoopbackIsBoundToLoopback) {
  const int one = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  std::uint32_t address = INADDR_ANY;
  DomainNetworks loopback("lo");
  ASSERT_TRUE(loopback.Bind(one, address));
  EXPECT_EQ(address, Address("127.0.0.1"));
  EXPECT_TRUE(loopback.Release(one));
  // elsewhere an address of today may not be one of tomorrow
  address = Address("10.0.0.1");
  DomainNetworks all("");
  ASSERT_TRUE(all.Bind(one, address));
  EXPECT_EQ(address, std::uint32_t{INADDR_ANY});
  EXPECT_TRUE(all.Release(one));
  close(one);
}

TEST(DomainNetworks, OnlyAnAddressThatIsInUseIsMissed) {
  const NetworkTable::Row lan{.interface = 2, .address = Address("10.0.0.1")};
  const NetworkTable::Row bridge{.interface = 3, .address = Address("172.17.0.1")};
  const NetworkTable::Row vpn{.interface = 4, .address = Address("10.8.0.1")};
  DomainNetworks networks("");
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t now_ns = 100 * kSecond;
  networks.Note({.from = Address("10.0.0.2"), .at = lan.address, .interface = 2}, now_ns - kSecond);
  networks.Note(
      {.from = Address("172.17.0.2"), .at = bridge.address, .interface = 3, .to_group = true},
      now_ns - kSecond);
  networks.Note({.from = Address("10.8.0.2"), .at = vpn.address, .interface = 4},
                now_ns - 60 * kSecond);
  const NetworkTable all = TableOf({lan, bridge, vpn});
  EXPECT_FALSE(networks.OnChange(TableOf({lan}), all, now_ns));
  // others are heard there, but nobody sends to it
  EXPECT_FALSE(networks.OnChange(all, TableOf({lan, vpn}), now_ns));
  // nobody has sent to it for a minute
  EXPECT_FALSE(networks.OnChange(all, TableOf({lan, bridge}), now_ns));
  EXPECT_TRUE(networks.OnChange(all, TableOf({bridge, vpn}), now_ns));
  NetworkTable::Row moved = lan;
  moved.address = Address("10.0.0.7");
  EXPECT_TRUE(networks.OnChange(all, TableOf({moved, bridge, vpn}), now_ns));
}

TEST(DomainNetworks, PublicAddressesAreTold) {
  for (const char* const one : {"10.1.2.3", "172.16.0.1", "172.31.255.255", "192.168.1.1",
                                "100.64.0.1", "169.254.1.1", "127.0.0.1", "0.0.0.0"}) {
    EXPECT_FALSE(IsPublicAddress(Address(one))) << one;
  }
  for (const char* const one : {"9.255.255.255", "11.0.0.0", "172.15.0.1", "172.32.0.1",
                                "192.167.1.1", "100.128.0.1", "203.0.113.1"}) {
    EXPECT_TRUE(IsPublicAddress(Address(one))) << one;
  }
}

TEST(NetworkTable, HasLoopbackAndTheWayThere) {
  const NetworkTable& table = CurrentNetworks();
  EXPECT_TRUE(table.Has(Address("127.0.0.1")));
  EXPECT_FALSE(table.Has(Address("192.0.2.200")));
  EXPECT_EQ(SourceTowards(Address("127.0.0.9")), Address("127.0.0.1"));
  EXPECT_FALSE(RefreshNetworks());
}

}  // namespace
}  // namespace tandem
