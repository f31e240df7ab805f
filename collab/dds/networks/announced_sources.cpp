#include "collab/dds/networks/announced_sources.h"

#include <algorithm>

#include "engine/base/units.h"

namespace tandem {

AnnouncedSources::AnnouncedSources(std::uint64_t seed) : random_(seed | 1U), programs_(kPrograms) {}

void AnnouncedSources::SetMet(std::span<const ProgramId> programs) {
  met_.assign(programs.begin(), programs.end());
  for (Program& one : programs_) {
    if (one.heard_ns != 0 && std::ranges::find(met_, one.id) != met_.end()) one = {};
  }
}

bool AnnouncedSources::Lets(std::span<const std::uint8_t> program, std::uint32_t address,
                            double lease_s, std::int64_t now_ns) noexcept {
  Program* one = Find(program, now_ns);
  if (one == nullptr && lease_s == 0) return true;
  const bool is_met = std::ranges::any_of(met_, [&](const ProgramId& id) {
    return std::ranges::equal(id, program);
  });
  if (is_met) return true;
  if (one == nullptr) {
    one = &Add(program, now_ns);
    one->meet_ns = kMeetNs;
    one->meet_until_ns = now_ns + kMeetNs;
  }
  one->heard_ns = now_ns;
  const bool silent = now_ns < one->silent_until_ns;
  if (lease_s == 0) return !silent;

  const std::size_t index = IndexOf(*one, address);
  if (silent) return false;
  if (now_ns > one->meet_until_ns && one->count > 1) {
    one->taken = (one->taken + 1) % one->count;
    one->silent_until_ns = now_ns + one->lease_ns + kBeyondLeaseNs;
    one->meet_ns = std::min(2 * one->meet_ns, kMeetAtMostNs);
    one->meet_until_ns = one->silent_until_ns + one->meet_ns;
    one->lease_ns = 0;
    return false;
  }
  if (index != one->taken) return false;
  one->lease_ns = std::max(one->lease_ns, static_cast<std::int64_t>(1e9 * lease_s));
  return true;
}

AnnouncedSources::Program* AnnouncedSources::Find(std::span<const std::uint8_t> program,
                                                  std::int64_t now_ns) noexcept {
  for (Program& one : programs_) {
    if (one.heard_ns == 0 || !std::ranges::equal(one.id, program)) continue;
    if (now_ns - one.heard_ns < kForgetNs) return &one;
    one = {};
    return nullptr;
  }
  return nullptr;
}

AnnouncedSources::Program& AnnouncedSources::Add(std::span<const std::uint8_t> program,
                                                 std::int64_t now_ns) noexcept {
  Program& one = *std::ranges::min_element(programs_, {}, &Program::heard_ns);
  one = {};
  std::ranges::copy(program, one.id.begin());
  one.heard_ns = now_ns;
  return one;
}

std::size_t AnnouncedSources::IndexOf(Program& program, std::uint32_t address) noexcept {
  const auto begin = program.sources.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(program.count);
  if (const auto found = std::find(begin, end, address); found != end) {
    return static_cast<std::size_t>(found - begin);
  }
  std::size_t index = program.count;
  if (program.count < kSources) {
    ++program.count;
  } else {
    // the address that is taken keeps its place, and its turn
    random_ = random_ * 6364136223846793005U + 1442695040888963407U;
    index = (program.taken + 1 + (random_ >> 33U) % (kSources - 1)) % kSources;
  }
  program.sources[index] = address;
  return index;
}

}  // namespace tandem
