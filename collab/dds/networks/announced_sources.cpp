#include "collab/dds/networks/announced_sources.h"

#include <algorithm>
#include <utility>

namespace tandem {

AnnouncedSources::AnnouncedSources(std::uint64_t seed)
    : seed_(seed | 1U), programs_(kSets * kWays) {}

void AnnouncedSources::SetMet(std::vector<ProgramId>& programs) noexcept {
  std::swap(met_, programs);
  for (Program& one : programs_) {
    if (one.heard_ns != 0 && IsMet(one.id)) one = {};
  }
}

bool AnnouncedSources::Lets(std::span<const std::uint8_t> program, std::int64_t now_ns) noexcept {
  Program* const one = Find(program, now_ns);
  if (one == nullptr) return true;
  one->heard_ns = now_ns;
  return now_ns >= one->silent_until_ns;
}

bool AnnouncedSources::LetsAnnounce(std::span<const std::uint8_t> program,
                                    const AnnouncedSource& source, std::int64_t now_ns,
                                    bool& new_turn) noexcept {
  if (IsMet(program)) return true;
  if (source.lease_s < kShortestLease || source.lease_s > kLongestLease) return false;
  Program* one = Find(program, now_ns);
  if (one == nullptr) {
    one = &Add(program, now_ns);
    one->meet_until_ns = now_ns + kMeetNs;
  }
  one->heard_ns = now_ns;
  const std::size_t index = Note(*one, source.way, now_ns);
  if (now_ns < one->silent_until_ns) return false;

  // in a silence nothing may have been heard at all
  const std::int64_t heard_ns = std::max(one->sources[one->taken].heard_ns, one->silent_until_ns);
  const bool taken_is_fresh = now_ns - heard_ns < kFreshNs;
  if ((now_ns > one->meet_until_ns || !taken_is_fresh) && TakeTurn(*one, now_ns)) {
    new_turn = true;
    one->silent_until_ns = now_ns + kSilenceNs;
    one->meet_until_ns = one->silent_until_ns + kMeetNs;
    return false;
  }
  return index == one->taken;
}

bool AnnouncedSources::IsMet(std::span<const std::uint8_t> program) const noexcept {
  const auto found = std::lower_bound(met_.begin(), met_.end(), program,
                                      [](const ProgramId& met, std::span<const std::uint8_t> id) {
                                        return std::ranges::lexicographical_compare(met, id);
                                      });
  return found != met_.end() && std::ranges::equal(*found, program);
}

std::span<AnnouncedSources::Program> AnnouncedSources::SetOf(
    std::span<const std::uint8_t> program) noexcept {
  std::uint64_t hash = seed_;
  for (const std::uint8_t byte : program) hash = (hash ^ byte) * 0x9E3779B97F4A7C15U;
  return std::span(programs_).subspan((hash >> 40U) % kSets * kWays, kWays);
}

AnnouncedSources::Program* AnnouncedSources::Find(std::span<const std::uint8_t> program,
                                                  std::int64_t now_ns) noexcept {
  for (Program& one : SetOf(program)) {
    if (one.heard_ns == 0 || !std::ranges::equal(one.id, program)) continue;
    if (now_ns - one.heard_ns < kForgetNs) return &one;
    one = {};
    return nullptr;
  }
  return nullptr;
}

AnnouncedSources::Program& AnnouncedSources::Add(std::span<const std::uint8_t> program,
                                                 std::int64_t now_ns) noexcept {
  Program& one = *std::ranges::min_element(SetOf(program), {}, &Program::heard_ns);
  one = {};
  std::ranges::copy(program, one.id.begin());
  one.heard_ns = now_ns;
  return one;
}

// Returns the source's place, or kSources if there is none.
std::size_t AnnouncedSources::Note(Program& program, std::uint64_t way,
                                   std::int64_t now_ns) noexcept {
  std::size_t place = kSources;
  for (std::size_t i = 0; i < kSources; ++i) {
    Source& one = program.sources[i];
    if (one.heard_ns != 0 && one.way == way) {
      one.heard_ns = now_ns;
      return i;
    }
    const bool silent = one.heard_ns == 0 || now_ns - one.heard_ns >= kFreshNs;
    const bool is_taken = i == program.taken && one.heard_ns != 0;
    if (place == kSources && !is_taken && (silent || one.tried)) place = i;
  }
  if (place < kSources) program.sources[place] = {.way = way, .heard_ns = now_ns, .tried = false};
  return place;
}

// Takes the next source that is not silent, one that had no turn before the others. Returns whether
// there is one.
bool AnnouncedSources::TakeTurn(Program& program, std::int64_t now_ns) noexcept {
  program.sources[program.taken].tried = true;
  for (int pass = 0; pass < 2; ++pass) {
    for (std::size_t step = 1; step < kSources; ++step) {
      const std::size_t i = (program.taken + step) % kSources;
      const Source& one = program.sources[i];
      if (one.tried || one.heard_ns == 0 || now_ns - one.heard_ns >= kFreshNs) continue;
      program.taken = i;
      return true;
    }
    // each had its turn
    for (Source& one : program.sources) one.tried = false;
    program.sources[program.taken].tried = true;
  }
  return false;
}

}  // namespace tandem
