#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "engine/base/hash.h"
#include "engine/base/image_bytes.h"
#include "engine/base/result.h"

namespace tandem {

/// Begins a file that holds what was made of a mesh, and that programs map into memory:
///
///   header       | what the file is, and of what it was made
///   first block  |
///   second block | may be empty
///
/// Each block begins on a cache line. Bytes between them are 0.
struct BlockFileHeader {
  std::array<char, 8> magic{};
  std::uint32_t version = 0;
  std::uint32_t unused = 0;
  std::uint64_t bytes = 0;     // of the whole file
  std::uint64_t checksum = 0;  // of all other bytes
  std::uint64_t mesh = 0;      // MadeOf
  std::uint64_t settings = 0;
  double voxel_size = 0;  // m
  std::array<std::uint64_t, 2> block_bytes{};
};
static_assert(sizeof(BlockFileHeader) == 72);

/// Tells one kind of file from others.
struct BlockFileKind {
  std::array<char, 8> magic;
  std::uint32_t version;  // of what is in it
  const char* what;       // "surface", for people
};

/// Identifies what a file's content was made of: the same numbers mean the same content.
struct MadeOf {
  std::uint64_t mesh = 0;      // of the mesh as it stands in W
  std::uint64_t settings = 0;  // of the options, and of what is fixed beside them

  bool operator==(const MadeOf&) const = default;
};

/// Writes blocks to a file, whole or not at all: a name beside it is written and then moved there.
/// Nothing, or what went wrong.
std::optional<Error> SaveBlocks(const BlockFileKind& kind, const MadeOf& made_of, double voxel_size,
                                const std::array<std::span<const std::byte>, 2>& blocks,
                                const std::filesystem::path& file);

struct BlockFile {
  MadeOf made_of;
  double voxel_size = 0;  // m
  std::array<ImageBlock, 2> blocks;
};

/// Maps a file, read-only. All bytes are read once, so that they are in memory, where
/// realtime_setup.h locks them. Refused in one line: a file that is not there, of another kind or
/// version, cut short or damaged.
Result<BlockFile> MapBlocks(const BlockFileKind& kind, const std::filesystem::path& file);

/// The same of a file whose content was made of something. Refused as well: one that was made of
/// something else.
Result<BlockFile> MapBlocks(const BlockFileKind& kind, const std::filesystem::path& file,
                            const MadeOf& made_of);

/// Refuses a file whose bytes are those that were saved and yet make no sense.
Error DamagedFile(const BlockFileKind& kind, const std::string& file);

/// The checksum of a file's bytes, at least a header.
std::uint64_t BlockFileChecksum(std::span<const std::byte> file);

/// As Hash64, eight words at a time: for gigabytes.
std::uint64_t HashOfMany(std::span<const std::byte> bytes);

/// Adds the hashes of a megabyte after another, which are found in parallel.
void AddPieces(std::span<const std::byte> bytes, Hash64& hash);

}  // namespace tandem
