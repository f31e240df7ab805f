#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "engine/base/files/image_bytes.h"
#include "engine/base/files/sha256.h"
#include "engine/base/hash.h"
#include "engine/base/result.h"

namespace tandem {

/// The beginning of a file that holds what was made of a mesh, and that programs map into memory:
///
///   header       | the kind of the file, and its sources
///   first block  |
///   second block | may be empty
///
/// Each block begins on a cache line. Bytes between them are 0.
struct BlockFileHeader {
  std::array<char, 8> magic{};
  std::uint32_t version = 0;
  std::uint32_t unused = 0;
  std::uint64_t bytes = 0;     // size of the whole file
  std::uint64_t checksum = 0;  // checksum of all other bytes
  Sha256 mesh{};               // BlockFileSources
  Sha256 settings{};
  double voxel_size = 0;  // m
  std::array<std::uint64_t, 2> block_bytes{};
};
static_assert(sizeof(BlockFileHeader) == 120);

/// A kind of file.
struct BlockFileKind {
  std::array<char, 8> magic;
  std::uint32_t version;  // version of the content
  const char* what;       // name for people, as "surface"
};

/// The sources of a file's content: the same digests mean the same content, whoever made the mesh.
struct BlockFileSources {
  Sha256 mesh{};      // digest of the mesh as it stands in W
  Sha256 settings{};  // digest of the options, and of what is fixed besides them

  bool operator==(const BlockFileSources&) const = default;
};

/// Writes blocks to a file, whole or not at all: it writes a file beside it and moves that there.
/// Returns nothing, or the error.
std::optional<Error> SaveBlocks(const BlockFileKind& kind, const BlockFileSources& made_of,
                                double voxel_size,
                                const std::array<std::span<const std::byte>, 2>& blocks,
                                const std::filesystem::path& file);

struct BlockFile {
  BlockFileSources made_of;
  double voxel_size = 0;  // m
  std::array<ImageBlock, 2> blocks;
};

/// Maps a file, read-only. It reads all bytes once, so that they are in memory, where
/// realtime_setup.h locks them. Errors, in one line: a file that does not exist, has another kind
/// or version, or is cut short or damaged.
Result<BlockFile> MapBlocks(const BlockFileKind& kind, const std::filesystem::path& file);

/// Does the same for a file with known sources. A file with other sources is an error as well.
Result<BlockFile> MapBlocks(const BlockFileKind& kind, const std::filesystem::path& file,
                            const BlockFileSources& made_of);

/// Returns the error for a file whose bytes are those that were saved and yet make no sense.
Error DamagedFile(const BlockFileKind& kind, const std::string& file);

/// Returns the checksum of a file's bytes, which are at least a header. It finds accidents: who can
/// write to the file can also give it another checksum.
std::uint64_t BlockFileChecksum(std::span<const std::byte> file);

/// Returns a hash as Hash64, eight words at a time: for gigabytes. It finds accidents, too.
std::uint64_t HashOfMany(std::span<const std::byte> bytes);

}  // namespace tandem
