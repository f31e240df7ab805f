#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tandem {

/// The share of its addresses that a queue's cursor passes in a frame; 1 is all of them.
using Fraction = double;

/// Keeps addresses (blocks of points, or whole chunks) in queues by their distance to contact
/// (paper §5; decision 0014). A queue is a bitmap over all addresses with an upper level of one bit
/// per 64, so that stretches without a member cost nothing. An address stands in one queue, or in
/// none (asleep).
///
///   upper  |0 1 0 0 1 ...|            one bit per leaf word, set if any of its bits is
///   leaf   |0000|0110|0000|0000|1000|  one bit per address
///
/// A queue's cursor runs over its range of addresses, not over its members. When it has gone once
/// round, it has passed every address, whatever has moved between queues meanwhile. If the cursor
/// advances by (travel made / allowance) of the range, no address waits for more travel than the
/// queue's allowance. This makes skipping safe (docs/decisions/0014-schedule.md). The range is cut
/// into strips that are run through side by side, which evens out the load.
///
/// Used by one thread, except PutBeside(). Never allocates after construction.
class DistanceQueues {
 public:
  static constexpr int kQueues = 16;
  static constexpr int kAsleep = 255;

  explicit DistanceQueues(std::size_t addresses);

  std::size_t addresses() const noexcept { return queue_of_.size(); }
  /// Returns the queue of an address; kAsleep when it is in none.
  int queue_of(std::size_t address) const noexcept { return queue_of_[address]; }
  std::size_t count(int queue) const noexcept { return counts_[At(queue)]; }
  std::size_t awake() const noexcept;

  /// Moves an address into a queue, from wherever it was.
  void Put(std::size_t address, int queue) noexcept;
  /// The number of addresses that came to each queue, less those that left.
  using Moves = std::array<std::ptrdiff_t, kQueues>;
  /// Does the same for several threads at once, each with addresses and moves of its own. No other
  /// member may run meanwhile. count() does not change until Add() was called with all moves.
  void PutBeside(std::size_t address, int queue, Moves& moves) noexcept;
  void Add(const Moves& moves) noexcept;
  /// Takes an address out of its queue.
  void Sleep(std::size_t address) noexcept;

  /// Calls visit(address) for every member.
  template <typename Visit>
  void VisitAll(int queue, const Visit& visit) {
    VisitRange(queue, 0, addresses(), visit);
  }

  /// Advances the queue's cursor by a fraction of its range and calls visit(address) for every
  /// member that it passes. The members must not change queue within.
  template <typename Visit>
  void Sweep(int queue, Fraction advance, const Visit& visit) {
    const Passed passed = Advance(queue, advance);
    for (std::size_t strip = 0; strip < kStrips; ++strip) VisitPassed(queue, passed, strip, visit);
  }

  /// The range that a cursor passes in each strip, as shares of the strip. `to` is 1 or more where
  /// the cursor begins again. Several threads may visit different strips at once.
  static constexpr std::size_t kStrips = 32;
  struct Passed {
    Fraction from = 0;
    Fraction to = 0;
  };
  static constexpr Passed kAll{0, 1};
  Passed Advance(int queue, Fraction advance) {
    if (advance <= 0) return {};
    if (advance >= 1.0) return kAll;
    const Fraction from = cursors_[At(queue)];
    const Fraction to = from + advance;
    cursors_[At(queue)] = to >= 1.0 ? to - 1.0 : to;
    return {from, to};
  }
  std::size_t StripBegin(std::size_t strip) const { return addresses() * strip / kStrips; }
  template <typename Visit>
  void VisitPassed(int queue, const Passed& passed, std::size_t strip, const Visit& visit) {
    if (counts_[At(queue)] == 0 || passed.to <= passed.from) return;
    const std::size_t begin = StripBegin(strip);
    const std::size_t end = StripBegin(strip + 1);
    const auto length = static_cast<Fraction>(end - begin);
    // an address is passed when the cursor passes its lower end
    const auto first = begin + CeilOf(passed.from * length);
    if (passed.to < 1.0) {
      VisitRange(queue, first, std::min(end, begin + CeilOf(passed.to * length)), visit);
    } else {
      VisitRange(queue, first, end, visit);
      VisitRange(queue, begin, std::min(end, begin + CeilOf((passed.to - 1.0) * length)), visit);
    }
  }

  /// Calls visit(address) for the next `count` members, round robin: the rule as printed (paper §5,
  /// Eqn. 3).
  template <typename Visit>
  void VisitNext(int queue, std::size_t count, const Visit& visit) {
    count = std::min(count, counts_[At(queue)]);
    std::size_t& next = next_[At(queue)];
    while (count > 0) {
      if (next >= addresses()) next = 0;
      const std::size_t word = next >> 6;
      const std::uint64_t rest = Leaf(queue, word) & (~std::uint64_t{0} << (next & 63));
      if (rest == 0) {
        next = (word + 1) << 6;
        continue;
      }
      const auto address = (word << 6) + static_cast<std::size_t>(std::countr_zero(rest));
      visit(address);
      next = address + 1;
      --count;
    }
  }

 private:
  static std::size_t At(int queue) noexcept { return static_cast<std::size_t>(queue); }
  static std::size_t CeilOf(double x) noexcept {
    const auto down = static_cast<std::size_t>(x);
    return down + (static_cast<double>(down) < x ? 1 : 0);
  }
  std::uint64_t& Leaf(int queue, std::size_t word) noexcept {
    return leaves_[At(queue) * words_ + word];
  }
  std::uint64_t Leaf(int queue, std::size_t word) const noexcept {
    return leaves_[At(queue) * words_ + word];
  }

  /// Visits the members with first <= address < last.
  template <typename Visit>
  void VisitRange(int queue, std::size_t first, std::size_t last, const Visit& visit) {
    if (first >= last) return;
    std::uint64_t* upper = &uppers_[At(queue) * upper_words_];
    const std::size_t first_word = first >> 6;
    const std::size_t last_word = (last - 1) >> 6;
    for (std::size_t u = first_word >> 6; u <= last_word >> 6; ++u) {
      const std::atomic_ref upper_word(upper[u]);
      std::uint64_t any = upper_word.load(std::memory_order_relaxed);
      if (u == first_word >> 6) any &= ~std::uint64_t{0} << (first_word & 63);
      if (u == last_word >> 6) any &= ~std::uint64_t{0} >> (63 - (last_word & 63));
      for (; any != 0; any &= any - 1) {
        const std::size_t word = (u << 6) + static_cast<std::size_t>(std::countr_zero(any));
        std::uint64_t bits = Leaf(queue, word);
        if (bits == 0) {  // PutBeside() left it; strips may share the word
          upper_word.fetch_and(~(std::uint64_t{1} << (word & 63)), std::memory_order_relaxed);
          continue;
        }
        if (word == first_word) bits &= ~std::uint64_t{0} << (first & 63);
        if (word == last_word) bits &= ~std::uint64_t{0} >> (63 - ((last - 1) & 63));
        for (; bits != 0; bits &= bits - 1) {
          visit((word << 6) + static_cast<std::size_t>(std::countr_zero(bits)));
        }
      }
    }
  }

  void Clear(std::size_t address, int queue) noexcept;

  std::size_t words_;
  std::size_t upper_words_;
  std::vector<std::uint64_t> leaves_;
  std::vector<std::uint64_t> uppers_;
  std::vector<std::uint8_t> queue_of_;
  std::array<std::size_t, kQueues> counts_{};
  std::array<Fraction, kQueues> cursors_{};
  std::array<std::size_t, kQueues> next_{};
};

}  // namespace tandem
