#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/files/sha256.h"
#include "engine/base/result.h"

namespace tandem {

/// A file of a scene in a list of files. No file name goes over the network, only its kind, one of
/// a few known here.
struct ListedFile {
  std::string kind;  // ".json", ".stl", …
  std::uint64_t bytes = 0;
  Sha256 digest{};
  std::vector<Sha256> pieces;
};

/// The files of a scene: first the scene file, in which "file:1" stands for the second file of the
/// list, then the mesh files, each once. Two peers with the same files make the same list.
struct SceneList {
  static constexpr std::size_t kMostFiles = 257;
  static constexpr std::uint64_t kMostSceneBytes = 4U << 20U;  // size of the scene file

  std::vector<ListedFile> files;

  std::uint64_t total_bytes() const;
  std::uint32_t pieces() const;  // sum over all files
};

/// Returns whether files of that kind travel.
bool IsSceneFileKind(std::string_view kind);

/// The place of a piece that is numbered over all files of a list.
struct PiecePlace {
  std::size_t file = 0;
  std::uint32_t piece = 0;  // number in the file
  std::uint64_t at = 0;     // offset in the file, bytes
  std::size_t bytes = 0;
};
std::uint32_t PiecesOf(std::uint64_t bytes);
/// Returns the place of a piece; `number` is below list.pieces().
PiecePlace PlaceOf(const SceneList& list, std::uint32_t number);

std::vector<char> Encode(const SceneList& list);
/// Decodes a list from an unknown sender. An error says in a line why a list is refused: it is
/// malformed, or its files are larger than `most_bytes` together.
Result<SceneList> DecodeList(std::span<const char> bytes, std::uint64_t most_bytes);
/// Returns the size of the largest list whose files have `most_bytes` together.
std::uint64_t MostListBytes(std::uint64_t most_bytes);

/// Packs pieces as they travel: compressed where that makes them smaller.
class PieceCoder {
 public:
  PieceCoder();
  ~PieceCoder();
  PieceCoder(const PieceCoder&) = delete;
  PieceCoder& operator=(const PieceCoder&) = delete;

  /// Packs a piece into `out`; returns whether it is compressed.
  bool Pack(std::span<const char> piece, std::vector<char>& out);
  /// Fills all of `piece`; returns false if `bytes` do not hold it. Never writes beyond `piece`,
  /// whatever `bytes` say.
  bool Unpack(std::span<const char> bytes, bool compressed, std::span<char> piece);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem
