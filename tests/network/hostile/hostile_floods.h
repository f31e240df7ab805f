#pragma once

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "app/process/child_processes.h"
#include "collab/dds/security/keys.h"
#include "tests/network/hostile/flood_growth.h"
#include "tests/network/hostile/stopped_thread.h"
#include "tests/network/running_program.h"

namespace tandem::testing {

inline constexpr double kFloodSeconds = 3;
// a DDS domain that no other test has: packets flood all programs of the domain
inline constexpr const char* kDomain = "71";
inline constexpr double kFullSeconds = 600;  // longest time of a flood of a given size

/// Returns how much a flood of that mode sends where TANDEM_FLOODS asks for full size; 0: it goes
/// by the clock.
inline long FullSizeOf(const std::string& mode) {
  if (std::getenv("TANDEM_FLOODS") == nullptr) return 0;  // NOLINT(concurrency-mt-unsafe)
  if (mode == "keys" || mode == "names" || mode == "lookers") return 1'000'000;
  return mode == "packets" ? 100'000 : 0;
}

/// A session with one peer of the product, that holds a body.
class HostileFloods : public ::testing::Test {
 protected:
  HostileFloods() : session_("floods-" + std::to_string(std::random_device{}())) {}

  std::filesystem::path In(const std::string& file) const { return folder_.path() / file; }
  Program Peer(const std::vector<std::string>& more = {}) const {
    const std::filesystem::path scenes = TANDEM_SCENES;
    std::vector<std::string> words{TANDEM_PROGRAM,
                                   "peer",
                                   "--session",
                                   session_,
                                   "--interface",
                                   "lo",
                                   "--domain",
                                   kDomain,
                                   "--scene",
                                   (scenes / "peg_in_slot.json").string(),
                                   "--hold",
                                   "peg",
                                   "--name",
                                   "anna",
                                   "--capacity",
                                   "20000",
                                   "--brief",
                                   "--report",
                                   In("report").string()};
    words.insert(words.end(), more.begin(), more.end());
    return Program(words, In("anna"));
  }
  /// Starts the peer of a secured session, with keys for an attacker of that name beside it.
  Program SecuredPeer(const std::string& attacker, Role role) const {
    const std::filesystem::path keys = In("keys");
    EXPECT_TRUE(MakeSessionKeys(keys));
    EXPECT_TRUE(MakeMemberKeys(keys, "anna", Role::kActive, In("keys-anna")));
    EXPECT_TRUE(MakeMemberKeys(keys, attacker, role, In("keys-" + attacker)));
    return Peer({"--secure", In("keys-anna").string()});
  }
  Program Attack(const std::string& mode, const std::string& keys = "-") const {
    const long size = FullSizeOf(mode);
    return Attack(mode, keys, size > 0 ? kFullSeconds : kFloodSeconds, size);
  }
  /// It ends after so many seconds, or when it has sent `most`; 0: it goes by the clock alone. One
  /// that waits for nobody comes before other programs, or on a busy machine it would be no flood.
  Program Attack(const std::string& mode, const std::string& keys, double seconds,
                 long most = 0) const {
    Program attacker({TANDEM_ATTACKER, session_, keys, "153", mode, std::to_string(seconds),
                      std::to_string(most), "lo", "-", kDomain},
                     In("attacker"));
    if (mode != "hosts")
      setpriority(PRIO_PROCESS, static_cast<id_t>(attacker.process().pid()), -20);
    return attacker;
  }
  nlohmann::json Report() const {
    std::ifstream stream(In("report"));
    return nlohmann::json::parse(stream, nullptr, false);
  }

  /// Growth of a program's memory in a flood, in bytes more than before it.
  struct Growth {
    std::int64_t most = 0;
    std::int64_t kept = 0;  // the least of the minute after it
  };

  /// Lets the attack run against a program that is there already. It begins when the program has
  /// heard of a peer `knows` (empty: it hears of none) and its memory stands still.
  Growth GrowthUnder(const std::string& mode, Program& victim, const std::string& knows = "vic",
                     const std::string& keys = "-") {
    Program attacker = Attack(mode, keys);
    EXPECT_TRUE(attacker.Says("joined")) << attacker.output();
    // it has no scene
    if (!knows.empty()) {
      EXPECT_TRUE(victim.Says(knows + " is not accepted")) << victim.output();
    }
    const std::int64_t before = MemoryAtRest(victim);
    EXPECT_GT(before, 0);
    const std::size_t lines_before = LinesOf(victim.output()).size();
    const auto begun = std::chrono::steady_clock::now();
    std::optional<StoppedThread> stopped;
    if (!stopped_thread_.empty()) {
      stopped.emplace(victim.process().pid(), stopped_thread_);
      EXPECT_TRUE(stopped->stopped());
    }
    attacker.process().Signal(SIGUSR1);
    Growth growth;
    while (!attacker.process().Poll()) {
      growth.most = std::max(growth.most, victim.Memory() - before);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    stopped.reset();
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    lines_ = LinesOf(victim.output()).size() - lines_before;
    EXPECT_THAT(attacker.output(), ::testing::HasSubstr("sent "));
    sent_ = std::stol(attacker.output().substr(attacker.output().find("sent ") + 5));
    if (FullSizeOf(mode) > 0) {
      EXPECT_EQ(sent_, FullSizeOf(mode));
    }
    growth.kept = victim.Memory() - before;
    for (double waited = 0; growth.kept > kMostKept && waited < kGivenBackSeconds; waited += 0.1) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      growth.kept = std::min(growth.kept, victim.Memory() - before);
    }
    RecordProperty("sent", static_cast<int>(sent_));
    RecordProperty("growth_kb", static_cast<int>(growth.most / 1024));
    RecordProperty("kept_kb", static_cast<int>(growth.kept / 1024));
    return growth;
  }
  static void ExpectLittle(const Growth& growth) {
    EXPECT_LE(growth.most, kMostGrowth);
    EXPECT_LE(growth.kept, kMostKept);
  }

  const TemporaryFolder folder_;
  const std::string session_;
  std::string stopped_thread_;  // victim's thread, stopped during the flood; empty: none
  long sent_ = 0;
  double seconds_ = 0;     // duration of the flood
  std::size_t lines_ = 0;  // number of lines that the victim said meanwhile
};

}  // namespace tandem::testing
