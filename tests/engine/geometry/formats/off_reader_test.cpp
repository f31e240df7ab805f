// Tests what OFF files say besides plain faces: each is honoured, told, or refused. Inputs are
// cubes of side 1.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/geometry/formats/native_readers.h"
#include "tests/engine/geometry/formats/misread_files.h"
#include "tests/engine/geometry/formats/read_answers.h"

namespace tandem {
namespace {

using testing::ExpectNot;
using testing::ExpectRead;
using testing::ExpectReadWith;
using testing::kOffCube;
using testing::MisreadFiles;
using testing::With;

const std::string kSmallFaceTold = "1 face with fewer than three corners left out";

/// Returns the cube in binary, at a distance on x, behind this head.
std::string BinaryOffCube(const std::string& head, float distance = 0,
                          const std::vector<std::uint32_t>& more = {}) {
  std::string bytes = head;
  const auto put = [&](std::uint32_t number) {
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift);
  };
  const auto put_real = [&](float number) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &number, sizeof bits);
    put(bits);
  };
  put(8);
  put(more.empty() ? 6 : 7);
  put(0);
  for (unsigned i = 0; i < 8; ++i) {
    put_real(distance + static_cast<float>(i & 1U));
    put_real(static_cast<float>(i >> 1U & 1U));
    put_real(static_cast<float>(i >> 2U & 1U));
  }
  for (const auto& face : std::vector<std::vector<std::uint32_t>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    put(4);
    for (const std::uint32_t corner : face) put(corner);
    put(0);
  }
  for (const std::uint32_t number : more) put(number);
  return bytes;
}

TEST(OffReader, HeadMayBeInAnyLettersAndBehindRemarks) {
  ASSERT_TRUE(kOffCube.starts_with("OFF"));
  const std::string rest = kOffCube.substr(3);
  ExpectRead(1, ReadOff("off" + rest));
  ExpectRead(1, ReadOff("Off" + rest));
  ExpectRead(1, ReadOff("# a cube\nOFF" + rest));
  ExpectRead(1, ReadOff(BinaryOffCube("OFF BINARY\n")));
  ExpectRead(1, ReadOff(BinaryOffCube("off binary\r\n")));
  ExpectRead(1, ReadOff(BinaryOffCube("# a cube\n# of one\nOFF BINARY\n")));
}

TEST(OffReader, LinesMayEndInAnyWay) {
  std::string returns = kOffCube;
  std::ranges::replace(returns, '\n', '\r');
  ExpectRead(1, ReadOff(returns));
  std::string both;
  for (const char c : kOffCube) both += c == '\n' ? std::string("\r\n") : std::string(1, c);
  ExpectRead(1, ReadOff(both));
}

TEST(OffReader, WordsBehindAPositionMustBeNumbers) {
  ExpectRead(1, ReadOff(With(kOffCube, "\n1 0 0\n", "\n1 0 0 255 0 0.5\n")));
  ExpectRead(1, ReadOff(With(kOffCube, "\n1 0 0\n", "\n1 0 0 # a corner\n")));
  ExpectNot("one that is not three numbers", ReadOff(With(kOffCube, "\n1 0 0\n", "\n1 0 0 mm\n")));
  ExpectNot("one that is not three numbers", ReadOff(With(kOffCube, "\n1 0 0\n", "\n1 0 0 0,5\n")));
}

TEST(OffReader, FacesOfFewerThanThreeCornersAreTold) {
  const std::string seven = With(kOffCube, "8 6", "8 7");
  ExpectReadWith(1, kSmallFaceTold, ReadOff(seven + "2 0 1\n"));
  ExpectReadWith(1, kSmallFaceTold, ReadOff(seven + "1 0\n"));
  ExpectReadWith(1, kSmallFaceTold, ReadOff(BinaryOffCube("OFF BINARY\n", 0, {2, 0, 1, 0})));
}

TEST_F(MisreadFiles, CoarseNumbersOfABinaryOffFileAreTold) {
  std::vector<std::string> remarks;
  const std::string far = BinaryOffCube("OFF BINARY\n", 1e6F);
  ASSERT_TRUE(ImportMesh(folder_.Write("far.off", far), {}, &remarks));
  EXPECT_THAT(remarks, ::testing::ElementsAre(::testing::HasSubstr("its 32-bit numbers are")));
}

}  // namespace
}  // namespace tandem
