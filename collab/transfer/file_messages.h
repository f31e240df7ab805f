#pragma once

#include <bitset>
#include <cstdint>
#include <functional>
#include <vector>

#include "collab/messages.h"
#include "collab/transfer/digest.h"

namespace tandem {

/// What a program that lacks a session's scene and the peers that have its files say to one
/// another; idl/tandem.idl is its form on the wire. Whoever fetches asks for pieces, and asks again
/// for those that were lost; whoever serves answers, at a limited rate.
/// docs/decisions/0049-scene-travels.md

/// Bytes of a file that go in one message; the last piece of a file may be shorter.
inline constexpr std::size_t kPieceBytes = 32768;
/// The piece numbers that one ask names, counted from its first.
inline constexpr std::size_t kAskSpan = 256;

/// Topic file/ask, or review/file_ask of a viewer.
struct FileAsk {
  enum class Kind : std::uint8_t {
    kOffer,  // "who has the scene of this content?"
    kList,   // pieces of a list of files
    kFiles   // pieces of the files that a list names, counted through all of them
  };

  PeerId from = 0;
  std::uint64_t program = 0;  // the asker's program, as the transport tells it apart
  PeerId to = 0;              // 0: all
  Kind kind = Kind::kOffer;
  std::uint64_t content_hash = 0;  // of the scene
  FileDigest list{};               // digest of the list of files
  std::uint32_t first = 0;
  std::bitset<kAskSpan> wanted;  // pieces first, first + 1, …
  std::uint32_t rate = 0;        // bytes/s that the asker can take
};

/// Topic file/piece: what answers.
struct FilePiece {
  PeerId from = 0;
  std::uint64_t program = 0;  // the sender's, as the transport tells it apart
  PeerId to = 0;
  FileAsk::Kind kind = FileAsk::Kind::kOffer;
  std::uint64_t content_hash = 0;
  FileDigest list{};
  std::uint32_t list_bytes = 0;   // of an offer: the list's size; 0: it is being made
  std::uint64_t total_bytes = 0;  // of an offer: the sum of the files' sizes
  std::uint32_t number = 0;       // of the piece
  std::int64_t sent_ns = 0;       // the sender's clock
  bool compressed = false;        // one Zstandard frame
  std::vector<char> bytes;        // of the piece; none in an offer
};

/// The side of a transfer that a program is on. A transport calls it on one thread of its own.
class FileParty {
 public:
  /// How it says something. What cannot be sent is lost.
  struct Out {
    std::function<void(const FileAsk&)> ask;
    std::function<void(const FilePiece&)> piece;
    std::function<std::size_t()> listeners;  // programs that hear pieces
  };

  virtual ~FileParty() = default;
  virtual bool serves() const = 0;  // else it fetches
  /// Whether it wants to hear and to say anything now. While it fetches nothing, others send it
  /// nothing: each program that hears pieces costs those who serve a copy of them.
  virtual bool wants() { return true; }
  virtual void OnAsk(const FileAsk& /*ask*/, std::int64_t /*now_ns*/) {}
  virtual void OnPiece(const FilePiece& /*piece*/, std::int64_t /*now_ns*/) {}
  /// Says what is due. Returns when it is to be called again at the latest.
  virtual std::int64_t Turn(std::int64_t now_ns, const Out& out) = 0;
  /// Whatever takes long gives up.
  virtual void Stop() {}
};

}  // namespace tandem
