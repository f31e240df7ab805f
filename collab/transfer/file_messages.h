#pragma once

#include <bitset>
#include <cstdint>
#include <functional>
#include <vector>

#include "collab/session/messages.h"
#include "engine/base/files/sha256.h"

namespace tandem {

/// Messages between a program that lacks a session's scene and the peers that have its files;
/// idl/tandem.idl is their wire format. The fetching program asks for pieces, and asks again for
/// lost ones. A serving peer answers, at a limited rate. docs/decisions/0049-scene-travels.md

/// Bytes of a file in one message; the last piece of a file may be shorter.
inline constexpr std::size_t kPieceBytes = 32768;
/// Piece numbers that one ask can name, counted from its first.
inline constexpr std::size_t kAskSpan = 256;

/// A request; topic file/ask, or review/file_ask of a viewer.
struct FileAsk {
  enum class Kind : std::uint8_t {
    kOffer,  // "who has the scene of this content?"
    kList,   // pieces of a list of files
    kFiles   // pieces of the files that a list names, counted through all of them
  };

  PeerId from = 0;
  std::uint64_t program = 0;  // the requester's program, as the transport identifies it
  PeerId to = 0;              // 0: all
  Kind kind = Kind::kOffer;
  std::uint64_t content_hash = 0;  // hash of the scene
  Sha256 list{};                   // digest of the list of files
  std::uint32_t first = 0;
  std::bitset<kAskSpan> wanted;  // pieces first, first + 1, …
  std::uint32_t rate = 0;        // bytes/s that the requester can take
};

/// An answer; topic file/piece.
struct FilePiece {
  PeerId from = 0;
  std::uint64_t program = 0;  // the sender's program, as the transport identifies it
  PeerId to = 0;
  FileAsk::Kind kind = FileAsk::Kind::kOffer;
  std::uint64_t content_hash = 0;
  Sha256 list{};
  std::uint32_t list_bytes = 0;   // in an offer: size of the list; 0: it is being made
  std::uint64_t total_bytes = 0;  // in an offer: sum of the files' sizes
  std::uint32_t number = 0;       // number of the piece
  std::int64_t sent_ns = 0;       // the sender's clock
  bool compressed = false;        // one Zstandard frame
  std::vector<char> bytes;        // bytes of the piece; none in an offer
};

/// One side of a transfer. A transport calls it on a separate thread.
class TransferEndpoint {
 public:
  /// Functions that send its messages. Messages that cannot be sent are lost.
  struct Out {
    std::function<void(const FileAsk&)> ask;
    std::function<void(const FilePiece&)> piece;
    std::function<std::size_t()> listeners;  // number of programs that receive pieces
  };

  virtual ~TransferEndpoint() = default;
  virtual bool serves() const = 0;  // else it fetches
  /// Returns whether it takes part in transfers now. While it fetches nothing, others send it
  /// nothing: every program that receives pieces costs the serving peers a copy of them.
  virtual bool wants() { return true; }
  virtual void OnAsk(const FileAsk& /*ask*/, std::int64_t /*now_ns*/) {}
  virtual void OnPiece(const FilePiece& /*piece*/, std::int64_t /*now_ns*/) {}
  /// Sends the messages that are due. Returns the latest time for the next call.
  virtual std::int64_t Tick(std::int64_t now_ns, const Out& out) = 0;
  /// Makes lengthy work give up.
  virtual void Stop() {}
};

}  // namespace tandem
