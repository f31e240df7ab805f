#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/network/networks/machines.h"

namespace tandem::testing {

enum class Bridge : std::uint8_t { kWithoutCarrier, kWithCarrier };

struct Arrangement {
  std::array<std::string, 3> order;  // in which the interfaces are made
  Bridge bridge = Bridge::kWithoutCarrier;
  std::string path = "lan";  // the interface that leads to the other machine
  bool named = false;        // --peers
  bool secured = false;

  std::string Text() const {
    return order[0] + " " + order[1] + " " + order[2] +
           (bridge == Bridge::kWithCarrier ? ", carrier" : ", no carrier") + ", path " + path +
           (named ? ", --peers" : "") + (secured ? ", secured" : "");
  }
};

/// Returns all arrangements: six orders, the bridge, the path, --peers, keys. The path is the LAN
/// in one half and the VPN in the other, so that each path meets each of the other choices.
inline std::vector<Arrangement> AllArrangements() {
  std::vector<Arrangement> all;
  std::array<std::string, 3> order{"docker0", "lan", "vpn"};
  do {
    for (int i = 0; i < 16; ++i) {
      all.push_back({.order = order,
                     .bridge = (i & 1) != 0 ? Bridge::kWithCarrier : Bridge::kWithoutCarrier,
                     .path = (i & 2) != 0 ? "vpn" : "lan",
                     .named = (i & 4) != 0,
                     .secured = (i & 8) != 0});
    }
  } while (std::ranges::next_permutation(order).found);
  return all;
}

/// Two machines, made as an arrangement says.
class TwoMachines {
 public:
  TwoMachines(const Arrangement& arrangement, const Machine& nowhere) : made_(arrangement) {
    for (const Machine* one : {&a_, &b_}) {
      if (!one->why_not().empty()) return;
    }
    for (const std::string& name : arrangement.order) good_ = good_ && Make(name, nowhere);
  }
  bool good() const { return good_; }
  const std::string& why_not() const { return a_.why_not(); }
  const Machine& a() const { return a_; }
  const Machine& b() const { return b_; }
  std::string AddressOf(int i) const {
    return (made_.path == "lan" ? "10.9.0." : "10.8.0.") + std::to_string(i + 1);
  }
  /// Gives `b` another address on the path, and takes the old one away. The kernel takes the VPN's
  /// route away with the last address.
  bool Move() const {
    if (made_.path == "lan") {
      return b_.Run("ip addr del 10.9.0.2/24 dev lan; ip addr add 10.9.0.7/24 dev lan");
    }
    return a_.Run("ip route add 10.8.0.7/32 dev vpn") &&
           b_.Run(
               "ip addr del 10.8.0.2/32 dev vpn; ip addr add 10.8.0.7/32 dev vpn; "
               "ip route replace 10.8.0.1/32 dev vpn");
  }
  /// Links the two by a new network.
  bool Add(const std::string& name, const std::string& network) const {
    return Link(a_, name, b_, name) &&
           a_.Run("ip addr add " + network + ".1/24 dev " + name + "; ip link set " + name +
                  " up") &&
           b_.Run("ip addr add " + network + ".2/24 dev " + name + "; ip link set " + name + " up");
  }
  bool Remove(const std::string& name) const { return a_.Run("ip link del " + name); }

 private:
  bool Make(const std::string& name, const Machine& nowhere) const {
    static int links = 0;
    const bool leads = name == made_.path;
    if (leads && !Link(a_, name, b_, name)) return false;
    for (int i = 0; i < 2; ++i) {
      const Machine& machine = i == 0 ? a_ : b_;
      if (name == "docker0") {
        // both machines have the same, as they come from the factory
        const bool carrier = made_.bridge == Bridge::kWithCarrier;
        if (!machine.Run(
                "ip link add docker0 type bridge; ip link add port type veth peer name "
                "inside; ip link set port master docker0; ip addr add 172.17.0.1/16 dev "
                "docker0; " +
                std::string(carrier ? "ip link set port up; ip link set inside up; " : "") +
                "ip link set docker0 up")) {
          return false;
        }
        continue;
      }
      if (!leads) {
        const std::string end = "end" + std::to_string(++links);
        if (!Link(machine, name, nowhere, end) || !nowhere.Run("ip link set " + end + " up")) {
          return false;
        }
      }
      const std::string own = std::to_string(i + 1);
      const std::string lines =
          name == "lan" ? "ip addr add 10.9.0." + own + "/24 dev lan; ip link set lan up"
                        : "ip addr add 10.8.0." + own +
                              "/32 dev vpn; ip link set vpn up; ip route add 10.8.0." +
                              std::to_string(2 - i) + "/32 dev vpn";
      if (!machine.Run(lines)) return false;
    }
    return true;
  }

  Arrangement made_;
  Machine a_;
  Machine b_;
  bool good_ = true;
};

}  // namespace tandem::testing
