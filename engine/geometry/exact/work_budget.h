#pragma once

#include <atomic>
#include <cstdint>

namespace tandem {

/// Counts work that several threads do together, up to a limit. What is counted depends on the
/// input alone, and so does whether it is too much: neither time nor the number of threads decides.
class WorkBudget {
 public:
  explicit WorkBudget(std::uint64_t most) : most_(most) {}

  /// Notes work; false: there is too much of it, and the caller gives up.
  bool Spend(std::uint64_t amount) {
    return done_.fetch_add(amount, std::memory_order_relaxed) + amount <= most_;
  }
  /// Tells whether there was too much work. Then what was made is not whole.
  bool exceeded() const { return done_.load(std::memory_order_relaxed) > most_; }

 private:
  std::uint64_t most_;
  std::atomic<std::uint64_t> done_ = 0;
};

/// Work of one thread, which notes it in large pieces. Without a budget there is no limit.
class WorkShare {
 public:
  explicit WorkShare(WorkBudget* budget) : budget_(budget) {}
  WorkShare(const WorkShare&) = delete;
  WorkShare& operator=(const WorkShare&) = delete;
  ~WorkShare() {
    if (budget_ != nullptr) budget_->Spend(held_);
  }

  /// Does as WorkBudget::Spend().
  bool Spend(std::uint64_t amount) {
    constexpr std::uint64_t kPiece = 4096;
    if (budget_ == nullptr) return true;
    held_ += amount;
    if (held_ < kPiece) return true;
    const std::uint64_t held = held_;
    held_ = 0;
    return budget_->Spend(held);
  }

 private:
  WorkBudget* budget_;
  std::uint64_t held_ = 0;
};

}  // namespace tandem
