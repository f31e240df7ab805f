#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace tandem {

/// This machine's usable networks, at a fixed size, so that threads that send and receive read it
/// without a lock.
struct NetworkTable {
  struct Row {
    unsigned interface = 0;
    std::uint32_t address = 0;
    bool loopback = false;
    std::array<char, 16> name{};
    bool operator==(const Row&) const = default;
  };
  static constexpr std::size_t kMost = 32;
  std::array<Row, kMost> rows{};
  std::size_t count = 0;

  std::span<const Row> used() const { return std::span(rows).first(count); }
  bool operator==(const NetworkTable&) const = default;
  bool Has(std::uint32_t address) const noexcept;
};

/// Returns the newest table. It stays valid for some seconds at least. The first call reads the
/// networks.
const NetworkTable& CurrentNetworks() noexcept;

/// Reads the networks anew. Returns whether the table has changed. One thread at a time.
bool RefreshNetworks();

/// Returns the address by which this machine sends to another one; 0: no network leads there.
std::uint32_t SourceTowards(std::uint32_t address);

/// Returns whether an address can be another machine's anywhere on the internet, and not only in a
/// private network.
bool IsPublicAddress(std::uint32_t address) noexcept;

}  // namespace tandem
