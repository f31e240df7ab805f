#include "engine/base/files/block_file.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>

#include "engine/base/files/whole_file.h"

namespace tandem {

namespace {

constexpr std::size_t kPiece = 1 << 20;

struct BlockPlaces {
  std::array<std::uint64_t, 2> blocks;
  std::uint64_t bytes;
};
BlockPlaces PlacesOf(const BlockFileHeader& header) {
  ArrayLayout arrays(sizeof header);
  BlockPlaces places{};
  places.blocks[0] = arrays.Add(header.block_bytes[0], 1);
  places.blocks[1] = arrays.Add(header.block_bytes[1], 1);
  places.bytes = arrays.bytes();
  return places;
}

/// Returns what is wrong with a file; nothing if all is well.
std::optional<Error> FaultOf(const BlockFileKind& kind, std::span<const std::byte> image,
                             const std::string& name, BlockFileHeader& header) {
  const std::string what = kind.what;
  if (image.size() < sizeof header) return Error{name + ": too short for a " + what};
  std::memcpy(&header, image.data(), sizeof header);
  if (header.magic != kind.magic) return Error{name + ": not a " + what};
  if (header.version != kind.version) {
    return Error{name + ": a " + what + " of version " + std::to_string(header.version) + ", not " +
                 std::to_string(kind.version) + "; voxelize its mesh again"};
  }
  if (header.bytes != image.size()) {
    return Error{name + ": " + std::to_string(image.size()) + " bytes of a " + what + " of " +
                 std::to_string(header.bytes) + "; it was cut short"};
  }
  if (header.checksum != BlockFileChecksum(image) || PlacesOf(header).bytes != header.bytes) {
    return DamagedFile(kind, name);
  }
  return std::nullopt;
}

}  // namespace

Error DamagedFile(const BlockFileKind& kind, const std::string& file) {
  return Error{file + ": a damaged " + kind.what + "; voxelize its mesh again"};
}

std::uint64_t HashOfMany(std::span<const std::byte> bytes) {
  constexpr std::uint64_t kPrime = 0x9e3779b97f4a7c15ULL;
  constexpr std::size_t kWords = 8;
  constexpr std::size_t kRow = kWords * sizeof(std::uint64_t);
  std::array<std::uint64_t, kWords> sums{1, 2, 3, 4, 5, 6, 7, 8};
  std::size_t at = 0;
  for (; at + kRow <= bytes.size(); at += kRow) {
    std::array<std::uint64_t, kWords> words;
    std::memcpy(words.data(), &bytes[at], kRow);
    for (std::size_t k = 0; k < kWords; ++k) {
      sums[k] = std::rotl((sums[k] ^ words[k]) * kPrime, 29);
    }
  }
  Hash64 hash;
  for (const std::uint64_t sum : sums) hash.Add(sum);
  const std::span<const std::byte> rest = bytes.subspan(at);
  hash.AddBytes(rest.data(), rest.size());
  return hash.value();
}

namespace {

/// Adds the hashes of one megabyte after another, computed in parallel.
void AddPieces(std::span<const std::byte> bytes, Hash64& hash) {
  std::vector<std::uint64_t> pieces((bytes.size() + kPiece - 1) / kPiece);
  tbb::parallel_for(std::size_t{0}, pieces.size(), [&](std::size_t i) {
    pieces[i] = HashOfMany(bytes.subspan(i * kPiece, std::min(kPiece, bytes.size() - i * kPiece)));
  });
  for (const std::uint64_t piece : pieces) hash.Add(piece);
}

}  // namespace

std::uint64_t BlockFileChecksum(std::span<const std::byte> file) {
  BlockFileHeader header;
  std::memcpy(&header, file.data(), sizeof header);
  header.checksum = 0;
  Hash64 hash;
  hash.AddBytes(&header, sizeof header);
  AddPieces(file.subspan(sizeof header), hash);
  return hash.value();
}

std::optional<Error> SaveBlocks(const BlockFileKind& kind, const BlockFileSources& made_of,
                                double voxel_size,
                                const std::array<std::span<const std::byte>, 2>& blocks,
                                const std::filesystem::path& file) {
  std::error_code code;
  const std::filesystem::file_status there = std::filesystem::status(file, code);
  if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there)) {
    return Error{file.string() + ": is not a regular file: name another"};
  }
  BlockFileHeader header{.magic = kind.magic,
                         .version = kind.version,
                         .mesh = made_of.mesh,
                         .settings = made_of.settings,
                         .voxel_size = voxel_size,
                         .block_bytes = {blocks[0].size(), blocks[1].size()}};
  const BlockPlaces places = PlacesOf(header);
  header.bytes = places.bytes;
  // block by block through one piece, so that there is no second image in memory
  std::vector<std::byte> piece;
  const auto fill = [&](std::uint64_t at) {
    piece.assign(std::min<std::uint64_t>(kPiece, header.bytes - at), std::byte{0});
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const std::uint64_t from = std::max(at, places.blocks[i]);
      const std::uint64_t to = std::min(at + piece.size(), places.blocks[i] + blocks[i].size());
      if (from >= to) continue;
      std::memcpy(&piece[from - at], &blocks[i][from - places.blocks[i]], to - from);
    }
  };
  Hash64 hash;
  hash.AddBytes(&header, sizeof header);
  for (std::uint64_t at = sizeof header; at < header.bytes; at += kPiece) {
    fill(at);
    hash.Add(HashOfMany(piece));
  }
  header.checksum = hash.value();

  Result<WholeFile> out = WholeFile::Create(file);
  if (!out) return out.error();
  const auto write = [&](const void* bytes, std::size_t size) {
    return out->Write({static_cast<const char*>(bytes), size});
  };
  bool written = write(&header, sizeof header);
  for (std::uint64_t at = sizeof header; written && at < header.bytes; at += kPiece) {
    fill(at);
    written = write(piece.data(), piece.size());
  }
  return out->Commit();
}

Result<BlockFile> MapBlocks(const BlockFileKind& kind, const std::filesystem::path& file) {
  Result<ImageBytes> mapped = ImageBytes::Map(file);
  if (!mapped) return mapped.error();
  const auto image = std::make_shared<const ImageBytes>(std::move(*mapped));
  const std::span<const std::byte> bytes(image->data(), image->size());
  BlockFileHeader header;
  if (std::optional<Error> fault = FaultOf(kind, bytes, file.string(), header)) return *fault;
  const BlockPlaces places = PlacesOf(header);
  BlockFile read{
      .made_of = {header.mesh, header.settings}, .voxel_size = header.voxel_size, .blocks = {}};
  for (std::size_t i = 0; i < read.blocks.size(); ++i) {
    read.blocks[i] = {image, bytes.subspan(places.blocks[i], header.block_bytes[i])};
  }
  return read;
}

Result<BlockFile> MapBlocks(const BlockFileKind& kind, const std::filesystem::path& file,
                            const BlockFileSources& made_of) {
  Result<BlockFile> mapped = MapBlocks(kind, file);
  if (mapped && mapped->made_of != made_of) {
    return Error{file.string() + ": a " + kind.what +
                 " of another mesh, or made with other options; voxelize this one"};
  }
  return mapped;
}

}  // namespace tandem
