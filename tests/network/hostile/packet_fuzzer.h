#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include <sys/types.h>

namespace tandem::testing {

using Packet = std::vector<unsigned char>;

/// Returns the UDP ports that a process listens at (IPv4).
std::vector<std::uint16_t> UdpPortsOf(pid_t process);

/// Makes bad packets of good ones: bytes flipped, set to limits or cut off, lengths that lie, two
/// packets in one, and some that were never any good. Seeded.
class PacketFuzzer {
 public:
  PacketFuzzer(std::vector<Packet> good, std::uint64_t seed);

  const Packet& Next();

 private:
  std::size_t Below(std::size_t limit) { return static_cast<std::size_t>(random_() % limit); }
  unsigned char SomeByte();
  void Mutate();

  std::vector<Packet> good_;
  std::mt19937_64 random_;
  Packet packet_;
};

}  // namespace tandem::testing
