#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "collab/transfer/digest.h"
#include "engine/base/result.h"

namespace tandem {

/// A file of a scene as a list of files names it. No name of a file goes over the network: what is
/// told is its kind, of a few that are known here.
struct ListedFile {
  std::string kind;  // ".json", ".stl", …
  std::uint64_t bytes = 0;
  FileDigest digest{};
  std::vector<FileDigest> pieces;
};

/// The files of a scene: first the scene file, in which "file:1" stands for the second file of the
/// list, and then the mesh files, each once. Two peers with the same files make the same list.
struct SceneList {
  static constexpr std::size_t kMostFiles = 257;
  static constexpr std::uint64_t kMostSceneBytes = 4U << 20U;  // of the scene file

  std::vector<ListedFile> files;

  std::uint64_t total_bytes() const;
  std::uint32_t pieces() const;  // of all files
};

/// The kinds of files that travel.
bool IsSceneFileKind(std::string_view kind);

/// Where a piece lies that is counted through all files of a list.
struct PiecePlace {
  std::size_t file = 0;
  std::uint32_t piece = 0;  // of the file
  std::uint64_t at = 0;     // byte of the file
  std::size_t bytes = 0;
};
std::uint32_t PiecesOf(std::uint64_t bytes);
/// `number` is below list.pieces().
PiecePlace PlaceOf(const SceneList& list, std::uint32_t number);

std::vector<char> Encode(const SceneList& list);
/// Reads what a stranger sent. Refuses a list that is not plain, of files that are larger than
/// `most_bytes` together, in a line.
Result<SceneList> DecodeList(std::span<const char> bytes, std::uint64_t most_bytes);
/// The largest list of files of so many bytes together.
std::uint64_t MostListBytes(std::uint64_t most_bytes);

/// The bytes of a piece as they travel: compressed where that makes them fewer.
class PieceCoder {
 public:
  PieceCoder();
  ~PieceCoder();
  PieceCoder(const PieceCoder&) = delete;
  PieceCoder& operator=(const PieceCoder&) = delete;

  /// Gives whether `out` is compressed.
  bool Pack(std::span<const char> piece, std::vector<char>& out);
  /// Fills all of `piece`; false: that is not what the bytes hold. Never writes beyond it, whatever
  /// they say of themselves.
  bool Unpack(std::span<const char> bytes, bool compressed, std::span<char> piece);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem
