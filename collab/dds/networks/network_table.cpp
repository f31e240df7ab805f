#include "collab/dds/networks/network_table.h"

#include <algorithm>
#include <atomic>
#include <mutex>

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "collab/dds/networks/usable_networks.h"

namespace tandem {
namespace {

NetworkTable ReadTable() {
  NetworkTable table;
  for (const NetworkAddress& one : UsableNetworks()) {
    if (table.count == NetworkTable::kMost) break;
    NetworkTable::Row& row = table.rows[table.count++];
    row.interface = one.interface;
    row.address = one.address;
    row.loopback = one.loopback;
    one.name.copy(row.name.data(), row.name.size() - 1);
  }
  return table;
}

// A reader keeps a table for microseconds. A place is used again after as many changes as there are
// places, and changes are some 0.2 s apart.
class Tables {
 public:
  const NetworkTable& Newest() const noexcept { return *newest_.load(std::memory_order_acquire); }
  bool Refresh() {
    const std::scoped_lock lock(mutex_);
    const NetworkTable table = ReadTable();
    if (table == Newest()) return false;
    place_ = (place_ + 1) % tables_.size();
    tables_[place_] = table;
    newest_.store(&tables_[place_], std::memory_order_release);
    return true;
  }

 private:
  std::mutex mutex_;
  std::array<NetworkTable, 64> tables_{ReadTable()};
  std::size_t place_ = 0;
  std::atomic<const NetworkTable*> newest_ = tables_.data();
};

Tables& SharedTables() {
  static auto& tables = *new Tables;
  return tables;
}

}  // namespace

bool NetworkTable::Has(std::uint32_t address) const noexcept {
  return std::ranges::any_of(used(), [address](const Row& row) {
    return row.address == address;
  });
}

const NetworkTable& CurrentNetworks() noexcept {
  return SharedTables().Newest();
}

bool RefreshNetworks() {
  return SharedTables().Refresh();
}

std::uint32_t SourceTowards(std::uint32_t address) {
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return 0;
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(9);
  to.sin_addr.s_addr = address;
  sockaddr_in own{};
  socklen_t size = sizeof own;
  // a datagram socket that is connected sends nothing; the kernel looks up the route
  const bool found = connect(probe, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0 &&
                     getsockname(probe, reinterpret_cast<sockaddr*>(&own), &size) == 0;
  close(probe);
  return found ? own.sin_addr.s_addr : 0;
}

bool IsPublicAddress(std::uint32_t address) noexcept {
  const std::uint32_t host = ntohl(address);
  const auto within = [host](std::uint32_t network, int bits) {
    return host >> (32 - bits) == network >> (32 - bits);
  };
  // RFC 1918, 6598, 3927, 1122
  return !within(0x0A000000, 8) && !within(0xAC100000, 12) && !within(0xC0A80000, 16) &&
         !within(0x64400000, 10) && !within(0xA9FE0000, 16) && !within(0x7F000000, 8) &&
         !within(0x00000000, 8);
}

}  // namespace tandem
