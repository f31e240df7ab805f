#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/voxel/map/voxmap.h"
#include "engine/voxel/points/pointshell.h"

namespace tandem {

/// A pointshell as the frame's tests read it: blocks of 16 points of one chunk and one label. A
/// block takes three whole cache lines and is the unit that is scheduled. Its points lie within a
/// few voxels of one another, so they come due together, and one vector instruction works on all of
/// them.
///
///   block | x 16 floats | y 16 floats | z 16 floats |    m, in the body's frame
///
/// Lanes past a block's count repeat its first point.
class PointBlocks {
 public:
  static constexpr std::size_t kLanes = 16;
  struct alignas(64) Lanes {
    std::array<float, kLanes> x;
    std::array<float, kLanes> y;
    std::array<float, kLanes> z;
  };
  struct Block {
    std::uint32_t first = 0;       // first point in the pointshell; the block's others follow
    std::uint32_t first_edge = 0;  // index into Pointshell::edges, for an edge block
    std::uint8_t count = 0;
    Label label = Label::kSurface;
  };
  /// A ball that holds a block's points, m.
  struct alignas(16) Ball {
    float x, y, z;  // centre
    float radius;
  };
  /// The blocks [first_block, first_block + block_count) of a chunk of the pointshell.
  struct Chunk {
    std::uint32_t first_block = 0;
    std::uint32_t block_count = 0;
    Vec3 p_BC = Vec3::Zero();
    double radius = 0;
  };

  explicit PointBlocks(const Pointshell& shell);

  std::size_t size() const noexcept { return blocks_.size(); }
  const Block& block(std::size_t b) const noexcept { return blocks_[b]; }
  const std::vector<Chunk>& chunks() const noexcept { return chunks_; }
  const Ball* balls() const noexcept { return balls_.data(); }
  const Lanes* positions() const noexcept { return positions_.data(); }
  const Lanes* normals() const noexcept { return normals_.data(); }
  const Field* fields() const noexcept { return fields_.data(); }  // field that each block reads
  /// Number of points of each block.
  const std::uint8_t* counts() const noexcept { return counts_.data(); }

 private:
  std::vector<Block> blocks_;
  std::vector<Chunk> chunks_;
  std::vector<Ball> balls_;
  std::vector<Lanes> positions_;
  std::vector<Lanes> normals_;
  std::vector<Field> fields_;
  std::vector<std::uint8_t> counts_;
};

}  // namespace tandem
