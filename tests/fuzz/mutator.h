#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace tandem {

/// Makes bad files from good ones: bits, numbers, words, pieces of one in another. Of one seed it
/// makes the same ones everywhere.
class Mutator {
 public:
  Mutator(std::vector<std::string> seeds, std::uint64_t seed);
  std::string Next();

 private:
  std::size_t Below(std::size_t n);
  void Change(std::string& bytes);
  void PutNumber(std::string& bytes);

  std::vector<std::string> seeds_;
  std::mt19937_64 random_;
};

}  // namespace tandem
