// Tests what PLY files say besides plain faces: each is honoured, told, or refused. Inputs are
// cubes of side 1.
#include <string>

#include <gtest/gtest.h>

#include "engine/geometry/formats/native_readers.h"
#include "tests/engine/geometry/formats/misread_files.h"
#include "tests/engine/geometry/formats/read_answers.h"

namespace tandem {
namespace {

using testing::ExpectNot;
using testing::ExpectRead;
using testing::ExpectReadWith;
using testing::kPlyCube;
using testing::With;

TEST(PlyReader, StripsAreReadWithTheirTurns) {
  // a tetrahedron of volume 1/6 as one strip of 1, 2, 3, 0 and two triangles
  const std::string strip =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
      "z\n"
      "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  ExpectRead(1.0 / 6, ReadPly(strip + "12 0 1 3 2 -1 0 2 1 -1 0 3 2\n"));
  ExpectNot("a face uses vertex 4", ReadPly(strip + "4 0 1 2 4\n"));
}

TEST(PlyReader, FacesOfFewerThanThreeCornersAreTold) {
  ExpectReadWith(1, "2 faces with fewer than three corners left out",
                 ReadPly(With(kPlyCube, "element face 6", "element face 8") + "2 0 1\n1 3\n"));
}

TEST(PlyReader, BinaryFloatsAreOfSinglePrecision) {
  const auto precise = [](const std::string& format, const std::string& type, int bytes) {
    return ReadPly(
        "ply\nformat " + format + " 1.0\nelement vertex 1\nproperty " + type + " x\nproperty " +
        type + " y\nproperty " + type +
        " z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n" +
        (format == "ascii" ? "0 0 0\n" : std::string(static_cast<std::size_t>(bytes), '\0')));
  };
  EXPECT_TRUE(precise("binary_little_endian", "float", 12).single_precision);
  EXPECT_TRUE(precise("binary_big_endian", "float32", 12).single_precision);
  EXPECT_FALSE(precise("binary_little_endian", "double", 24).single_precision);
  EXPECT_FALSE(precise("ascii", "float", 0).single_precision);
}

TEST(PlyReader, RemarksBehindNumbersAreSkipped) {
  ExpectRead(1, ReadPly(With(kPlyCube, "\n0 0 1\n", "\n0 0 1 # a corner\n")));
  ExpectRead(1, ReadPly(With(kPlyCube, "\n0 0 1\n", "\ncomment a corner\n0 0 1\n")));
  ExpectRead(1, ReadPly(kPlyCube + "# the end\n"));
}

TEST(PlyReader, WordsBehindANumberAreRefused) {
  for (const std::string word : {"1mm", "1,0", "1.0-1", "one"}) {
    ExpectNot("('" + word + "' is no number)",
              ReadPly(With(kPlyCube, "\n0 0 1\n", "\n0 0 " + word + "\n")));
  }
  ExpectRead(1, ReadPly(With(kPlyCube, "\n0 0 1\n", "\n0 0 0.1D+1\n")));
}

TEST(PlyReader, NumbersBeyondTheHeadsCountsAreRefused) {
  ExpectNot("it has more numbers than its head declares, from '4 0 1 2 3' on",
            ReadPly(kPlyCube + "4 0 1 2 3\n"));
  ExpectNot("it is shorter than the 600 of its face",
            ReadPly(With(kPlyCube, "element face 6", "element face 600")));
}

TEST(PlyReader, HeadThatIsNotUnderstoodIsRefused) {
  ExpectNot("its head has a line that is not understood: 'property float24 x'",
            ReadPly(With(kPlyCube, "property float x", "property float24 x")));
  ExpectNot("its vertices have not x, y and z",
            ReadPly(With(kPlyCube, "property float z", "property float w")));
  ExpectNot("its face has no list vertex_indices",
            ReadPly(With(kPlyCube, "vertex_indices", "corners")));
}

TEST(PlyReader, UnknownElementsAreTold) {
  ExpectReadWith(
      1, "its 1 of sphere are left out",
      ReadPly(With(kPlyCube, "end_header", "element sphere 1\nproperty float r\nend_header") +
              "0.5\n"));
}

TEST(PlyReader, UnitOfARemarkIsFound) {
  const ReadAnswer answer =
      ReadPly(With(kPlyCube, "element vertex", "comment units mm\nelement vertex"));
  ExpectRead(1, answer);
  EXPECT_EQ(answer.remarked_unit, 1e-3);
}

}  // namespace
}  // namespace tandem
