#include "collab/dds/wire/file_wire.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

FileAsk SomeAsk() {
  FileAsk ask;
  ask.from = 7;
  ask.to = 9;
  ask.kind = FileAsk::Kind::kFiles;
  ask.content_hash = 0x123456789ABCDEF0;
  ask.list[31] = 5;
  ask.first = 4711;
  ask.wanted[0] = ask.wanted[8] = ask.wanted[255] = true;
  ask.rate = 1'000'000;
  return ask;
}

TEST(FileWire, RequestsRoundTrip) {
  const FileAsk ask = SomeAsk();
  tandem_FileAsk wire;
  ToWire(ask, wire);
  FileAsk came;
  ASSERT_TRUE(FromWire(wire, came));
  EXPECT_EQ(came.from, ask.from);
  EXPECT_EQ(came.to, ask.to);
  EXPECT_EQ(came.kind, ask.kind);
  EXPECT_EQ(came.content_hash, ask.content_hash);
  EXPECT_EQ(came.list, ask.list);
  EXPECT_EQ(came.first, ask.first);
  EXPECT_EQ(came.wanted, ask.wanted);
  EXPECT_EQ(came.rate, ask.rate);
}

TEST(FileWire, PiecesRoundTrip) {
  FilePiece piece;
  piece.from = 7;
  piece.kind = FileAsk::Kind::kList;
  piece.list_bytes = 77;
  piece.total_bytes = std::uint64_t{1} << 40U;
  piece.number = 3;
  piece.sent_ns = -5;
  piece.compressed = true;
  piece.bytes = {'a', 'b', '\0'};
  tandem_FilePiece wire;
  ToWire(piece, wire);
  FilePiece came;
  ASSERT_TRUE(FromWire(wire, came));
  EXPECT_EQ(came.kind, piece.kind);
  EXPECT_EQ(came.list_bytes, piece.list_bytes);
  EXPECT_EQ(came.total_bytes, piece.total_bytes);
  EXPECT_EQ(came.number, piece.number);
  EXPECT_EQ(came.sent_ns, piece.sent_ns);
  EXPECT_TRUE(came.compressed);
  EXPECT_EQ(came.bytes, piece.bytes);
}

TEST(FileWire, InvalidMessagesAreRefused) {
  tandem_FileAsk ask;
  FileAsk came;
  ToWire(SomeAsk(), ask);
  ask.peer = 0;
  EXPECT_FALSE(FromWire(ask, came));
  ToWire(SomeAsk(), ask);
  ask.kind = static_cast<tandem_FileKind>(3);
  EXPECT_FALSE(FromWire(ask, came));
  FilePiece piece;
  piece.from = 7;
  tandem_FilePiece wire;
  ToWire(piece, wire);
  wire.bytes._length = kPieceBytes + 1;
  EXPECT_FALSE(FromWire(wire, piece));
  ToWire(piece, wire);
  wire.kind = static_cast<tandem_FileKind>(-1);
  EXPECT_FALSE(FromWire(wire, piece));
}

}  // namespace
}  // namespace tandem
