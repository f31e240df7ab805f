#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.h"

namespace tandem {

/// What a sweep's author holds of a cell: `control` must be measured unstable.
enum class Expectation : std::uint8_t { kNothing, kStable, kUnstable };
const char* NameOf(Expectation expectation);

/// One experiment of a sweep.
struct SweepCell {
  std::size_t number = 0;  // in the whole sweep, from 0, whatever the shard
  std::string key;         // 16 hexadecimal digits, of the case without its name and without
                           // a seed that the block does not set
  std::string case_json;   // on one line; with name and seed: what `tandem stability run` reads
  Expectation expect = Expectation::kNothing;
  double cost = 0;       // of running it, beside the others; it says what is run first
  std::size_t rank = 0;  // among all by cost, those alike mixed: it says in which shard it is
};

/// More are days of work for a hundred machines, or a mistake in a grid.
inline constexpr std::size_t kMostCells = 250'000;

/// A grid of experiments, of at most kMostCells.
struct Sweep {
  std::string name;
  std::uint64_t seed = 1;
  std::string hash;  // of seed, keys and expectations, in order: which sweep this is
  std::vector<SweepCell> cells;
};

/// Says what is wrong with a case, or nothing; `name` stands for the file.
using CaseCheck =
    std::function<std::optional<Error>(const std::string& case_json, const std::string& name)>;

/// Reads a sweep file (docs/stability-cluster.md): {"name", "seed", "blocks": [...]}, where each
/// key of a block is a value or an array of values. A block's cells are the product of its arrays,
/// the first of scene, users, hands, delay_s, network, publish_hz, law, ratio, boundary_ratio,
/// stiffness_N_m, motion, seconds, seed turning slowest; a cell that was there already is left out.
/// The cell's seed is the block's, or comes of the sweep's and of its key: neither order, nor other
/// blocks, nor shards bear on it. Errors name the file and the place in it.
Result<Sweep> LoadSweep(const std::filesystem::path& file, const CaseCheck& check);

/// Which part of a sweep: its cells with rank % of == index - 1, so that shards cost alike and have
/// cells of every kind.
struct Shard {
  std::size_t index = 1;  // from 1
  std::size_t of = 1;

  bool Has(const SweepCell& cell) const { return cell.rank % of == index - 1; }
  std::string Name() const { return std::to_string(index) + "/" + std::to_string(of); }
};

/// "3/20". Errors say what is expected.
Result<Shard> ParseShard(const std::string& text);

}  // namespace tandem
