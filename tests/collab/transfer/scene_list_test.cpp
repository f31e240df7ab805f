#include "collab/transfer/scene_list.h"

#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zstd.h>

#include "engine/base/text/hex.h"
#include "tests/collab/transfer/transfer_bench.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using testing::NoiseBytes;

// The examples are FIPS 180-4's own.
TEST(Sha256, IsSha256) {
  EXPECT_EQ(HexOfBytes(Sha256Of(std::string("abc"))),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(HexOfBytes(Sha256Of(std::string())),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

SceneList TwoFiles() {
  SceneList list;
  list.files.push_back({".json", 300, Sha256Of(std::string("a")), {Sha256{1}}});
  list.files.push_back(
      {".stl", 70'000, Sha256Of(std::string("b")), {Sha256{2}, Sha256{3}, Sha256{4}}});
  return list;
}

TEST(SceneList, RoundTrips) {
  const SceneList list = TwoFiles();
  const Result<SceneList> read = DecodeList(Encode(list), 1'000'000);
  ASSERT_TRUE(read) << read.error().what;
  ASSERT_EQ(read->files.size(), 2U);
  EXPECT_EQ(read->files[1].kind, ".stl");
  EXPECT_EQ(read->files[1].bytes, 70'000U);
  EXPECT_EQ(read->files[1].pieces, list.files[1].pieces);
  EXPECT_EQ(read->pieces(), 4U);
  const PiecePlace last = PlaceOf(*read, 3);
  EXPECT_EQ(last.file, 1U);
  EXPECT_EQ(last.at, 2 * kPieceBytes);
  EXPECT_EQ(last.bytes, 70'000 - 2 * kPieceBytes);
}

TEST(SceneList, InvalidListIsRefusedInOneLine) {
  const auto refusal = [](const std::function<void(SceneList&)>& change) {
    SceneList list = TwoFiles();
    change(list);
    const Result<SceneList> read = DecodeList(Encode(list), 1'000'000);
    return read ? std::string("taken") : read.error().what;
  };
  EXPECT_EQ(refusal([](SceneList&) {}), "taken");
  // a million files, or none
  EXPECT_THAT(refusal([](SceneList& list) {
                for (std::uint32_t i = 0; i < 1'000'000; ++i) {
                  list.files.push_back({".stl", 1, {}, {Sha256{}}});
                }
              }),
              HasSubstr("1000002 files; a scene has 2 to 257"));
  EXPECT_THAT(refusal([](SceneList& list) {
                list.files.pop_back();
              }),
              HasSubstr("1 files"));
  EXPECT_THAT(refusal([](SceneList& list) {
                list.files[1].bytes = UINT64_MAX;
              }),
              HasSubstr("more than 1 MB"));
  EXPECT_THAT(refusal([](SceneList& list) {
                list.files[1].bytes = 999'900;
              }),
              HasSubstr("more than 1 MB"));
  EXPECT_THAT(refusal([](SceneList& list) {
                list.files[1].bytes = 900'000;
              }),
              HasSubstr("cut short"));
  EXPECT_THAT(refusal([](SceneList& list) {
                list.files[1].bytes = 0;
              }),
              HasSubstr("an empty file"));
  EXPECT_THAT(refusal([](SceneList& list) {
                list.files[0].kind = ".stl";
              }),
              HasSubstr("a kind of file that no scene has"));
  EXPECT_THAT(refusal([](SceneList& list) {
                list.files[1].kind = ".json";
              }),
              HasSubstr("a kind of file that no scene has"));
  EXPECT_THAT(refusal([](SceneList& list) {
                list.files.push_back(list.files[1]);
              }),
              HasSubstr("a file twice"));
  std::vector<char> bytes = Encode(TwoFiles());
  bytes.push_back(0);
  EXPECT_THAT(DecodeList(bytes, 1'000'000).error().what, HasSubstr("behind its end"));
  bytes = Encode(TwoFiles());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(DecodeList(std::span(bytes).first(size), 1'000'000)) << size;
  }
  // whichever byte is changed, the list is read or refused, and never beyond its end
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (const int change : {1, 0x80, 0xFF}) {
      std::vector<char> other = bytes;
      other[i] = static_cast<char>(other[i] ^ change);
      const Result<SceneList> read = DecodeList(other, 1'000'000);
      if (read) {
        EXPECT_LE(read->total_bytes(), 1'000'000U);
      }
    }
  }
}

TEST(PieceCoder, RoundTripsAndCompresses) {
  PieceCoder coder;
  std::vector<char> packed;
  const std::string same(kPieceBytes, 'a');
  EXPECT_TRUE(coder.Pack(same, packed));
  EXPECT_LT(packed.size(), 100U);
  std::string piece(kPieceBytes, 0);
  EXPECT_TRUE(coder.Unpack(packed, true, piece));
  EXPECT_EQ(piece, same);
  const std::string noise = NoiseBytes(kPieceBytes, 5);
  EXPECT_FALSE(coder.Pack(noise, packed));
  EXPECT_EQ(packed.size(), kPieceBytes);
  EXPECT_TRUE(coder.Unpack(packed, false, piece));
  EXPECT_EQ(piece, noise);
  EXPECT_FALSE(coder.Unpack(packed, true, piece));
  EXPECT_FALSE(coder.Unpack(packed, false, std::span(piece).first(17)));
}

// 100 MB of zeros in a few kB: it is refused when a piece is full.
TEST(PieceCoder, DecompressionBombIsBoundedToAPiece) {
  std::vector<char> bomb(ZSTD_compressBound(100'000'000));
  {
    const std::vector<char> zeros(100'000'000);
    const std::size_t size = ZSTD_compress(bomb.data(), bomb.size(), zeros.data(), zeros.size(), 1);
    ASSERT_FALSE(ZSTD_isError(size));
    bomb.resize(size);
  }
  PieceCoder coder;
  std::vector<char> piece(kPieceBytes + 1, 'x');
  EXPECT_FALSE(coder.Unpack(bomb, true, std::span(piece).first(kPieceBytes)));
  EXPECT_EQ(piece.back(), 'x');
}

}  // namespace
}  // namespace tandem
