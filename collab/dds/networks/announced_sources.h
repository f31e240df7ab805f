#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collab/dds/cyclone/program_id.h"

namespace tandem {

/// Decides from which address a domain takes a program's announcement.
///
/// DDS answers a program where its first announcement came from, and an announcement is not proven.
/// So a stranger who sends a member's announcement again from its own address, before the member is
/// heard, would keep the two apart for good. In a secured session a program is met when its keys
/// are proven. One that is announced from several addresses and is not met in time is not heard
/// until DDS has forgotten it, and is taken from another of these addresses then. A program with
/// several networks is announced from several addresses too. It is met by the first that leads to
/// it, and from then on all are heard.
///
/// All memory is taken at construction. The class reads no clock. Used by one thread at a time.
class AnnouncedSources {
 public:
  static constexpr std::size_t kPrograms = 128;  // beyond it the one that was heard longest ago is
                                                 // forgotten
  static constexpr std::size_t kSources =
      16;  // addresses of one program; a further one takes the place of another
  static constexpr std::int64_t kMeetNs = 5'000'000'000;  // to meet a program in, at first; each
                                                          // further address has twice the time
  static constexpr std::int64_t kMeetAtMostNs = 40'000'000'000;
  static constexpr std::int64_t kForgetNs = 20'000'000'000;  // a silent program
  static constexpr std::int64_t kBeyondLeaseNs = 1'000'000'000;

  /// `seed`: chooses which address is replaced, so that nobody else can.
  explicit AnnouncedSources(std::uint64_t seed);

  /// Sets which programs are met now.
  void SetMet(std::span<const ProgramId> programs);
  /// Returns whether DDS may see a packet of the program from that address. `lease_s`: the time for
  /// which the packet asks DDS to remember the program; 0: it announces none.
  bool Lets(std::span<const std::uint8_t> program, std::uint32_t address, double lease_s,
            std::int64_t now_ns) noexcept;

 private:
  struct Program {
    ProgramId id{};
    std::array<std::uint32_t, kSources> sources{};
    std::size_t count = 0;           // number of sources
    std::size_t taken = 0;           // index of the source whose announcements DDS sees
    std::int64_t heard_ns = 0;       // 0: a free place
    std::int64_t meet_until_ns = 0;  // time by which it is to be met
    std::int64_t meet_ns = 0;        // time that it had for that
    std::int64_t silent_until_ns = 0;
    std::int64_t lease_ns = 0;  // longest that DDS was asked to remember it for
  };

  Program* Find(std::span<const std::uint8_t> program, std::int64_t now_ns) noexcept;
  Program& Add(std::span<const std::uint8_t> program, std::int64_t now_ns) noexcept;
  std::size_t IndexOf(Program& program, std::uint32_t address) noexcept;

  std::uint64_t random_;
  std::vector<Program> programs_;
  std::vector<ProgramId> met_;
};

}  // namespace tandem
