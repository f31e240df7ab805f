#include "collab/dds/wire/file_wire.h"

#include <algorithm>
#include <cstring>

namespace tandem {

namespace {

bool IsKind(tandem_FileKind kind) {
  return kind == tandem_FILE_OFFER || kind == tandem_FILE_LIST || kind == tandem_FILE_FILES;
}

}  // namespace

void ToWire(const FileAsk& ask, tandem_FileAsk& wire) noexcept {
  wire = {};
  wire.peer = ask.from;
  wire.to = ask.to;
  wire.kind = static_cast<tandem_FileKind>(ask.kind);
  wire.content_hash = ask.content_hash;
  std::ranges::copy(ask.list, wire.list);
  wire.first = ask.first;
  for (std::size_t i = 0; i < kAskSpan; ++i) {
    if (ask.wanted[i]) wire.wanted[i / 8] |= static_cast<std::uint8_t>(1U << (i % 8));
  }
  wire.rate = ask.rate;
}

bool FromWire(const tandem_FileAsk& wire, FileAsk& ask) noexcept {
  if (wire.peer == 0 || !IsKind(wire.kind)) return false;
  ask.from = wire.peer;
  ask.to = wire.to;
  ask.kind = static_cast<FileAsk::Kind>(wire.kind);
  ask.content_hash = wire.content_hash;
  std::ranges::copy(wire.list, ask.list.begin());
  ask.first = wire.first;
  for (std::size_t i = 0; i < kAskSpan; ++i) {
    ask.wanted[i] = (wire.wanted[i / 8] >> (i % 8) & 1U) != 0;
  }
  ask.rate = wire.rate;
  return true;
}

void ToWire(const FilePiece& piece, tandem_FilePiece& wire) noexcept {
  wire = {};
  wire.peer = piece.from;
  wire.to = piece.to;
  wire.kind = static_cast<tandem_FileKind>(piece.kind);
  wire.content_hash = piece.content_hash;
  std::ranges::copy(piece.list, wire.list);
  wire.list_bytes = piece.list_bytes;
  wire.total_bytes = piece.total_bytes;
  wire.number = piece.number;
  wire.sent_ns = piece.sent_ns;
  wire.compressed = piece.compressed;
  const auto size = static_cast<std::uint32_t>(std::min(piece.bytes.size(), kPieceBytes));
  wire.bytes._length = wire.bytes._maximum = size;
  // Cyclone only reads a sample that it sends
  wire.bytes._buffer =
      reinterpret_cast<std::uint8_t*>(const_cast<char*>(piece.bytes.data()));  // NOLINT
}

bool FromWire(const tandem_FilePiece& wire, FilePiece& piece) {
  if (wire.peer == 0 || !IsKind(wire.kind) || wire.bytes._length > kPieceBytes) return false;
  piece.from = wire.peer;
  piece.to = wire.to;
  piece.kind = static_cast<FileAsk::Kind>(wire.kind);
  piece.content_hash = wire.content_hash;
  std::ranges::copy(wire.list, piece.list.begin());
  piece.list_bytes = wire.list_bytes;
  piece.total_bytes = wire.total_bytes;
  piece.number = wire.number;
  piece.sent_ns = wire.sent_ns;
  piece.compressed = wire.compressed;
  piece.bytes.resize(wire.bytes._length);
  if (wire.bytes._length > 0) {
    std::memcpy(piece.bytes.data(), wire.bytes._buffer, wire.bytes._length);
  }
  return true;
}

}  // namespace tandem
