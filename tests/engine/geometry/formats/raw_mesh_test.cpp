#include "engine/geometry/formats/raw_mesh.h"

#include <array>
#include <cstring>

#include <gtest/gtest.h>
#include <unistd.h>

namespace tandem {
namespace {

std::string BytesOf(const ReadAnswer& answer) {
  std::array<int, 2> ends{};
  EXPECT_EQ(pipe(ends.data()), 0);
  EXPECT_TRUE(WriteAnswer(ends[1], answer));  // little enough for the pipe to hold
  close(ends[1]);
  std::string bytes(65536, '\0');
  const ssize_t size = read(ends[0], bytes.data(), bytes.size());
  close(ends[0]);
  bytes.resize(size < 0 ? 0 : static_cast<std::size_t>(size));
  return bytes;
}

ReadAnswer OneTriangle() {
  return {ReadAnswer::Kind::kMesh, "", {{{0, 0, 0}, {1, 0, 0}, {0, 2.5F, 0}}, {{0, 1, 2}}}};
}

TEST(RawMesh, RoundTripsThroughAPipe) {
  const std::optional<ReadAnswer> answer = ParseAnswer(BytesOf(OneTriangle()));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->kind, ReadAnswer::Kind::kMesh);
  EXPECT_EQ(answer->mesh.points, OneTriangle().mesh.points);
  EXPECT_EQ(answer->mesh.triangles, OneTriangle().mesh.triangles);

  const std::optional<ReadAnswer> refusal =
      ParseAnswer(BytesOf({ReadAnswer::Kind::kRefused, "no", {}}));
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->kind, ReadAnswer::Kind::kRefused);
  EXPECT_EQ(refusal->words, "no");
}

TEST(RawMesh, WrongLengthIsRefused) {
  std::string bytes = BytesOf(OneTriangle());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(ParseAnswer(std::string_view(bytes).substr(0, size))) << size;
  }
  bytes += '\0';
  EXPECT_FALSE(ParseAnswer(bytes));
}

TEST(RawMesh, AbsurdCountsAreRefused) {
  const std::string bytes = BytesOf(OneTriangle());
  for (std::size_t word = 0; word < 5; ++word) {  // magic, kind, words, points, triangles
    for (const std::uint64_t absurd : {~0ULL, 1ULL << 63U, 0x1555'5555'5555'5556ULL, 77ULL}) {
      std::string damaged = bytes;
      std::memcpy(damaged.data() + 8 * word, &absurd, 8);
      EXPECT_FALSE(ParseAnswer(damaged)) << word << " " << absurd;
    }
  }
}

}  // namespace
}  // namespace tandem
