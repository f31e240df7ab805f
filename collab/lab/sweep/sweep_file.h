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

/// The verdict that a sweep's author expects of a cell; a control must be measured unstable.
enum class Expectation : std::uint8_t { kNothing, kStable, kUnstable };
const char* NameOf(Expectation expectation);

/// One experiment of a sweep.
struct SweepCell {
  std::size_t number = 0;  // place in the whole sweep, from 0, the same for every shard
  std::string key;         // 16 hexadecimal digits, hash of the case without its name and without a
                           // seed that the block does not set
  std::string case_json;   // on one line, with name and seed, as `tandem stability run` reads it
  Expectation expect = Expectation::kNothing;
  double cost = 0;       // relative cost of running it; the costliest cells run first
  std::size_t rank = 0;  // place among all cells by cost, equal costs in a mixed order; it decides
                         // the shard
};

/// A sweep with more cells is days of work for a hundred machines, or a mistake in a grid.
inline constexpr std::size_t kMostCells = 250'000;

/// A grid of experiments, of at most kMostCells.
struct Sweep {
  std::string name;
  std::uint64_t seed = 1;
  std::string hash;  // hash of seed, keys and expectations in order; it identifies the sweep
  std::vector<SweepCell> cells;
};

/// Returns what is wrong with a case, or nothing; `name` stands for the file.
using CaseCheck =
    std::function<std::optional<Error>(const std::string& case_json, const std::string& name)>;

/// Reads a sweep file (docs/stability-cluster.md): {"name", "seed", "blocks": [...]}, where each
/// key of a block is a value or an array of values. A block's cells are the product of its arrays,
/// the first of scene, users, hands, delay_s, network, publish_hz, law, ratio, boundary_ratio,
/// stiffness_N_m, motion, seconds, seed turning slowest. A cell that an earlier block has is left
/// out. A cell's seed is the block's. Without one it follows from the sweep's seed and the cell's
/// key, whatever the order, the other blocks and the shards are. Errors name the file and the place
/// in it.
Result<Sweep> LoadSweep(const std::filesystem::path& file, const CaseCheck& check);

/// A part of a sweep: its cells with rank % of == index - 1. So shards cost alike and have cells of
/// every kind.
struct Shard {
  std::size_t index = 1;  // from 1
  std::size_t of = 1;

  bool Has(const SweepCell& cell) const { return cell.rank % of == index - 1; }
  std::string Name() const { return std::to_string(index) + "/" + std::to_string(of); }
};

/// Reads a shard such as "3/20". Errors say what is expected.
Result<Shard> ParseShard(const std::string& text);

}  // namespace tandem
