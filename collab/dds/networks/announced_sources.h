#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collab/dds/cyclone/program_id.h"

namespace tandem {

/// Where a program is announced from, and how.
struct AnnouncedSource {
  std::uint64_t way = 0;  // equal for equal announcements from one address
  double lease_s = 0;     // time for which DDS is to remember the program
};

/// Decides from which source a domain takes a program's announcement.
///
/// DDS answers a program where its first announcement came from, and an announcement is not proven.
/// So a stranger who sends a member's announcement again from its own address, before the member is
/// heard, would keep the two apart for good. In a secured session a program is met when its keys
/// are proven. One that is announced from several sources and is not met in time is not heard until
/// DDS has forgotten it, and is taken from another source then. A program with several networks has
/// several sources too. It is met by the first that leads to it, and from then on all are heard.
///
/// Programs are kept in sets, in an order that nobody else can know, so that a flood of invented
/// ones displaces few others. The class reads no clock. Used by one thread at a time.
class AnnouncedSources {
 public:
  static constexpr std::size_t kSets = 256;
  static constexpr std::size_t kWays = 4;  // programs in a set; a further one takes the place of
                                           // the one that was heard longest ago
  static constexpr std::size_t kSources = 16;  // sources of one program; a further one waits until
                                               // one is silent or had its turn
  static constexpr std::int64_t kMeetNs = 5'000'000'000;     // to meet a program in, each turn
  static constexpr std::int64_t kSilenceNs = 4'000'000'000;  // between two turns
  static constexpr std::int64_t kFreshNs = 3'000'000'000;  // a source silent for longer has no turn
  static constexpr std::int64_t kForgetNs = 20'000'000'000;  // a program silent for so long
  /// Bounds of the lease of a program not met. Tandem's is two seconds, and DDS must have forgotten
  /// the program at the end of the silence.
  static constexpr double kShortestLease = 1;
  static constexpr double kLongestLease = 3;

  explicit AnnouncedSources(std::uint64_t seed);

  /// Sets which programs are met now, the own one among them; `programs` is sorted and
  /// names each once.
  void SetMet(std::vector<ProgramId>& programs) noexcept;
  /// Returns whether no other program is met.
  bool IsAlone() const noexcept { return met_.size() <= 1; }
  /// Returns whether DDS may see a packet of the program that announces nothing.
  bool Lets(std::span<const std::uint8_t> program, std::int64_t now_ns) noexcept;
  /// Returns whether DDS may see an announcement of the program. `new_turn` becomes true if the
  /// program's silence begins.
  bool LetsAnnounce(std::span<const std::uint8_t> program, const AnnouncedSource& source,
                    std::int64_t now_ns, bool& new_turn) noexcept;

 private:
  struct Source {
    std::uint64_t way = 0;
    std::int64_t heard_ns = 0;  // 0: a free place
    bool tried = false;         // had its turn
  };
  struct Program {
    ProgramId id{};
    std::array<Source, kSources> sources{};
    std::size_t taken = 0;           // index of the source whose announcements DDS sees
    std::int64_t heard_ns = 0;       // 0: a free place
    std::int64_t meet_until_ns = 0;  // time by which it is to be met
    std::int64_t silent_until_ns = 0;
  };

  bool IsMet(std::span<const std::uint8_t> program) const noexcept;
  std::span<Program> SetOf(std::span<const std::uint8_t> program) noexcept;
  Program* Find(std::span<const std::uint8_t> program, std::int64_t now_ns) noexcept;
  Program& Add(std::span<const std::uint8_t> program, std::int64_t now_ns) noexcept;
  static std::size_t Note(Program& program, std::uint64_t way, std::int64_t now_ns) noexcept;
  static bool TakeTurn(Program& program, std::int64_t now_ns) noexcept;

  std::uint64_t seed_;
  std::vector<Program> programs_;
  std::vector<ProgramId> met_;
};

}  // namespace tandem
