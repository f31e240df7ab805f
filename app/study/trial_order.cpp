#include "app/study/trial_order.h"

#include <cstdio>
#include <numeric>
#include <utility>

#include "engine/base/hash.h"

namespace tandem {

namespace {

/// Shuffles after Fisher and Yates, with draws that are equal on every machine.
template <typename Value>
void ShuffleBy(std::vector<Value>& values, std::uint64_t seed, const std::string& what,
               std::uint64_t which) {
  for (std::size_t i = values.size(); i > 1; --i) {
    std::swap(values[i - 1], values[DrawOf(seed, what, which, i) % i]);
  }
}

std::vector<std::size_t> Numbers(std::size_t count) {
  std::vector<std::size_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  return numbers;
}

/// Returns the order of a block's conditions, as indices into StudyBlock::conditions.
std::vector<std::size_t> OrderOf(const Study& study, std::size_t block, int participant,
                                 int repetition) {
  const std::size_t count = study.blocks[block].conditions.size();
  const auto who = static_cast<std::uint64_t>(participant);
  switch (study.blocks[block].order) {
    case StudyOrder::kAsWritten:
      return Numbers(count);
    case StudyOrder::kShuffled: {
      std::vector<std::size_t> order = Numbers(count);
      ShuffleBy(order, study.seed, "order " + std::to_string(block),
                1000 * who + static_cast<std::uint64_t>(repetition));
      return order;
    }
    case StudyOrder::kWilliams:
      break;
  }
  const std::vector<std::vector<std::size_t>> rows = WilliamsRows(count);
  // as many participants as there are rows get each row once, in an order drawn by the seed
  std::vector<std::size_t> turns = Numbers(rows.size());
  ShuffleBy(turns, study.seed, "rows " + std::to_string(block), who / rows.size());
  std::vector<std::size_t> letters = Numbers(count);
  ShuffleBy(letters, study.seed, "letters " + std::to_string(block), 0);
  const std::size_t row =
      (turns[who % rows.size()] + static_cast<std::size_t>(repetition)) % rows.size();
  std::vector<std::size_t> order;
  for (const std::size_t treatment : rows[row]) order.push_back(letters[treatment]);
  return order;
}

}  // namespace

std::uint64_t DrawOf(std::uint64_t seed, const std::string& what, std::uint64_t first,
                     std::uint64_t second) {
  Hash64 hash;
  hash.Add(seed);
  hash.AddBytes(what.data(), what.size());
  hash.Add(first);
  hash.Add(second);
  return hash.value();
}

std::vector<std::vector<std::size_t>> WilliamsRows(std::size_t treatments) {
  const std::size_t n = treatments;
  // 0, 1, n-1, 2, n-2, ...: for even n all differences of neighbours are distinct
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < n; ++i) {
    first.push_back(i == 0 ? 0 : (i % 2 == 1 ? (i + 1) / 2 : n - i / 2));
  }
  std::vector<std::vector<std::size_t>> rows;
  for (std::size_t shift = 0; shift < n; ++shift) {
    std::vector<std::size_t> row;
    for (const std::size_t treatment : first) row.push_back((treatment + shift) % n);
    rows.push_back(std::move(row));
  }
  if (n % 2 == 0 || n == 1) return rows;
  for (std::size_t row = 0; row < n; ++row) rows.emplace_back(rows[row].rbegin(), rows[row].rend());
  return rows;
}

std::vector<PlannedTrial> TrialsOf(const Study& study, int participant) {
  std::vector<PlannedTrial> trials;
  for (std::size_t block = 0; block < study.blocks.size(); ++block) {
    for (int repetition = 0; repetition < study.blocks[block].repetitions; ++repetition) {
      int place = 0;
      for (const std::size_t which : OrderOf(study, block, participant, repetition)) {
        trials.push_back({.number = static_cast<int>(trials.size()) + 1,
                          .block = block,
                          .condition = study.blocks[block].conditions[which],
                          .repetition = repetition + 1,
                          .place = ++place});
      }
    }
  }
  return trials;
}

std::string TrialFolder(int number) {
  char name[24];
  std::snprintf(name, sizeof name, "trial-%03d", number);
  return name;
}

std::vector<std::string> PseudonymsOf(const Study& study) {
  // half as many numbers again as participants or more, so that no number reveals their count
  const auto count = static_cast<std::size_t>(study.participants);
  const std::size_t most = count <= 66 ? 99 : count <= 666 ? 999 : 9999;
  std::vector<std::size_t> numbers = Numbers(most);
  ShuffleBy(numbers, study.seed, "pseudonyms", 0);
  const int digits = most == 99 ? 2 : most == 999 ? 3 : 4;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) {
    char text[24];
    std::snprintf(text, sizeof text, "P%0*zu", digits, numbers[i] + 1);
    names.emplace_back(text);
  }
  return names;
}

}  // namespace tandem
