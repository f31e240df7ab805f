#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/base/files/image_bytes.h"
#include "engine/contact/features/body_features.h"

namespace tandem {

/// The layout of the block of bytes that holds a body's features. It means the same wherever it
/// lies:
///
///   header         | the number of entries of each array
///   blocks         | BodyFeatures::Block each
///   lanes          | BodyFeatures::Lanes per block
///   points         | BodyFeatures::Point per lane
///   chunks         | BodyFeatures::Chunk each
///   edges          | BodyFeatures::Edge each
///   slots          | a hash table of the cells with edges
///   edges by cell  | uint32 each: numbers of edges
///   edge distances | a byte per cell of the box round all edges
///
/// Each array begins on a cache line behind the previous one, so the counts alone tell the places.
struct FeatureHeader {
  double longest_half = 0;  // voxels
  GridIndex first_cell;     // first cell of the box round all edges
  GridIndex cell_count;
  std::uint64_t points = 0;  // without the lanes that repeat one
  std::uint64_t blocks = 0;
  std::uint64_t chunks = 0;
  std::uint64_t edges = 0;
  std::uint64_t slots = 0;
  std::uint64_t bytes = 0;  // size of the block
};
static_assert(sizeof(FeatureHeader) == 80);

/// Makes the blocks of bodies' features, and checks blocks that come from elsewhere.
class FeatureImage {
 public:
  /// The greatest number of blocks in a chunk.
  static constexpr std::size_t kMostBlocks = 64;

  /// Features in the making. Pack() fills in the header's counts of arrays.
  struct Parts {
    FeatureHeader header;
    std::vector<BodyFeatures::Block> blocks;
    std::vector<BodyFeatures::Lanes> lanes;
    std::vector<BodyFeatures::Point> points;
    std::vector<BodyFeatures::Chunk> chunks;
    std::vector<BodyFeatures::Edge> edges;
    std::vector<BodyFeatures::Slot> slots;
    std::vector<std::uint32_t> edges_by_cell;
    std::vector<std::uint8_t> edge_distances;
  };
  static BodyFeatures Pack(const Parts& parts);

  /// Returns the features of a block from an untrusted source; nothing, if reading them could leave
  /// the block or not end.
  static std::optional<BodyFeatures> Read(ImageBlock block);

 private:
  friend class BodyFeatures;

  struct Places {
    std::uint64_t blocks, lanes, points, chunks, edges, slots, edges_by_cell, edge_distances, bytes;
  };
  static Places PlacesOf(const FeatureHeader& header);
  static bool IsSound(const FeatureHeader& header);
  static bool BlocksAreSound(const BodyFeatures& features);
  static bool ChunksAreSound(const BodyFeatures& features);
  static bool EdgesAreSound(const BodyFeatures& features);
};

}  // namespace tandem
