#include "engine/contact/schedule/point_blocks.h"

#include <algorithm>

namespace tandem {

PointBlocks::PointBlocks(const Pointshell& shell) {
  chunks_.reserve(shell.chunks.size());
  for (const Pointshell::Chunk& chunk : shell.chunks) {
    Chunk out;
    out.first_block = static_cast<std::uint32_t>(blocks_.size());
    out.p_BC = chunk.p_BC;
    out.radius = chunk.radius;
    const std::uint32_t end = chunk.first + chunk.count;
    for (std::uint32_t first = chunk.first; first < end;) {
      // as many of one label as fit
      std::uint32_t last = first;
      while (last < end && last - first < kLanes && shell.label(last) == shell.label(first)) ++last;
      Block block;
      block.first = first;
      block.first_edge = chunk.first_edge + (first - chunk.first) -
                         chunk.labels[static_cast<std::size_t>(Label::kVertex)];
      block.count = static_cast<std::uint8_t>(last - first);
      block.label = shell.label(first);
      Lanes position;
      Lanes normal;
      Bounds box;
      for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
        const std::uint32_t point = first + lane < last ? first + lane : first;
        position.x[lane] = shell.x[point];
        position.y[lane] = shell.y[point];
        position.z[lane] = shell.z[point];
        normal.x[lane] = shell.nx[point];
        normal.y[lane] = shell.ny[point];
        normal.z[lane] = shell.nz[point];
        box.Add(shell.point(point));
      }
      const Vec3f p_BC = box.centre().cast<float>();
      double radius = 0;
      for (std::uint32_t point = first; point < last; ++point) {
        radius = std::max(radius, (shell.point(point) - p_BC.cast<double>()).norm());
      }
      // rounded up
      balls_.push_back({p_BC.x(), p_BC.y(), p_BC.z(), static_cast<float>(radius * (1 + 1e-6))});
      blocks_.push_back(block);
      positions_.push_back(position);
      normals_.push_back(normal);
      fields_.push_back(FieldReadBy(block.label));
      counts_.push_back(block.count);
      first = last;
    }
    out.block_count = static_cast<std::uint32_t>(blocks_.size()) - out.first_block;
    chunks_.push_back(out);
  }
}

}  // namespace tandem
