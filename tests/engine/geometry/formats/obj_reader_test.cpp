// Tests what OBJ files say besides plain faces: each is honoured, told, or refused. All inputs are
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
using testing::kObjCube;
using testing::With;

TEST(ObjReader, BackslashAtTheEndOfARemarkOrANameContinuesNothing) {
  for (const std::string line :
       {"# from C:\\parts\\", "usemtl C:\\parts\\", "mtllib C:\\parts\\", "g C:\\parts\\", "#\\"}) {
    ExpectRead(1, ReadObj(With(kObjCube, "f 1 3 4 2", line + "\nf 1 3 4 2")));
    ExpectRead(1, ReadObj(With(kObjCube, "v 1 0 1", line + "\nv 1 0 1")));
    ExpectRead(1, ReadObj(kObjCube + line + "\n"));
  }
}

// Exporters write a folder of textures where it does not belong.
TEST(ObjReader, BackslashBehindAnyOtherStatementEatsNoFace) {
  for (const std::string line : {"s off\\", "l 1 2\\", "p 3 \\", "vt 0 0\\", "vn 0 0 1 \\",
                                 "bevel on\\", "deg 3\\", "l 1 2\\\n3\\"}) {
    for (const std::string next : {"f 1 3 4 2", "v 1 0 1"}) {
      const ReadAnswer answer = ReadObj(With(kObjCube, next, line + "\n" + next));
      ASSERT_EQ(answer.kind, ReadAnswer::Kind::kMesh) << line << answer.words;
      EXPECT_EQ(answer.mesh.triangles.size(), 12U) << line;
    }
  }
  ExpectReadWith(1, "the first with 'map_kd'",
                 ReadObj(With(kObjCube, "f 1 3 4 2", "map_Kd C:\\tex\\\nf 1 3 4 2")));
  // a line of numbers continues it, and tells of nothing
  ExpectRead(1, ReadObj(With(kObjCube, "f 1 3 4 2", "vt 0 \\\n0.5 \\\n0\nf 1 3 4 2")));
}

TEST(ObjReader, BackslashAtTheEndOfNumbersContinuesThem) {
  ExpectRead(1, ReadObj(With(kObjCube, "f 1 3 4 2", "f 1 3 \\\n4 \\\r\n2")));
  ExpectRead(1, ReadObj(With(kObjCube, "v 1 0 1", "v 1 0\\\n1")));
  ExpectRead(1, ReadObj(With(kObjCube, "v 1 0 1", "v 1 0\\\n1 # a \\")));
}

TEST(ObjReader, FortransExponentIsAnExponent) {
  for (const std::string one : {"1.0D+00", "0.1d1", "10.D-1", "1d0", "100.0e-02"}) {
    ExpectRead(1, ReadObj(With(kObjCube, "v 1 0 1", "v " + one + " 0 1")));
  }
}

TEST(ObjReader, WordsBehindANumberAreRefused) {
  for (const std::string word :
       {"1mm", "1,000", "1,0", "1.0-1", "1e", "1.0f", "0x1", "one", "1.0.0"}) {
    ExpectNot("'" + word + "' is not a number",
              ReadObj(With(kObjCube, "v 1 0 1", "v " + word + " 0 1")));
  }
  ExpectNot("write it with a decimal point, and without separators of thousands",
            ReadObj(With(kObjCube, "v 1 0 1", "v 1,000 0 1")));
  ExpectNot("line 6: '1mm' is not a number: write it without a unit",
            ReadObj(With(kObjCube, "v 1 0 1", "v 1mm 0 1")));
  ExpectNot("'3;' is not a corner of a face", ReadObj(With(kObjCube, "f 1 3 4 2", "f 1 3; 4 2")));
}

TEST(ObjReader, RemarksBehindNumbersAreSkipped) {
  ExpectRead(1, ReadObj(With(kObjCube, "v 1 0 1", "v 1 0 1 # a corner, 5 mm")));
  ExpectRead(1, ReadObj(With(kObjCube, "f 1 3 4 2", "f 1 3 4 2# below")));
}

TEST(ObjReader, CornersCountFromTheEndAndHaveTexturesAndNormals) {
  ExpectRead(1, ReadObj(With(kObjCube, "f 1 3 4 2", "f -8 -6 -5 -7")));
  ExpectRead(1, ReadObj(With(kObjCube, "f 1 3 4 2", "f 1//1 3//1 4//1 2//1")));
  ExpectRead(1, ReadObj(With(kObjCube, "f 1 3 4 2", "f 1/2/3 3/2/3 4/2/3 2/2/3")));
  ExpectRead(1, ReadObj(With(kObjCube, "f 1 3 4 2", "f 1/ 3/ 4/ 2/")));
  ExpectRead(1, ReadObj(With(kObjCube, "f 1 3 4 2", "F 1 3 4 2")));
  ExpectNot("is out of range: '0'", ReadObj(With(kObjCube, "f 1 3 4 2", "f 0 3 4 2")));
  ExpectNot("is out of range: '-9'", ReadObj(With(kObjCube, "f 1 3 4 2", "f -9 3 4 2")));
  ExpectNot("line 9: vertex index 9 is out of range: there are only 8 vertices",
            ReadObj(With(kObjCube, "f 1 3 4 2", "f 9 3 4 2")));
}

TEST(ObjReader, WhatHasNoSurfaceIsTold) {
  ExpectReadWith(1, "2 line and point elements without a surface left out",
                 ReadObj(kObjCube + "l 1 2\np 3\n"));
  ExpectReadWith(1, "1 free-form curve or surface left out",
                 ReadObj(kObjCube + "cstype bspline\ndeg 3 3\nsurf 0 1 0 1 1 2 3 4\nend\n"));
  ExpectReadWith(1, "1 call of another file left out", ReadObj(kObjCube + "call other.obj\n"));
  ExpectReadWith(1, "1 face with fewer than three corners left out", ReadObj(kObjCube + "f 1 2\n"));
  ExpectReadWith(1, "1 line that is no statement of the format left out, the first with 'vertex'",
                 ReadObj(kObjCube + "vertex 1 2 3\n"));
  ExpectReadWith(1, "1 vertex with a weight other than 1 read without it",
                 ReadObj(With(kObjCube, "v 1 0 1", "v 1 0 1 0.5")));
}

TEST(ObjReader, LooksAreNotTold) {
  ExpectRead(1, ReadObj("mtllib a.mtl\no cube\ns off\n" +
                        With(kObjCube, "f 1 3", "vt 0 0\nvn 0 0 1\nusemtl m\nf 1 3")));
  ExpectRead(1, ReadObj(With(kObjCube, "v 1 0 1", "v 1 0 1 0.5 0.5 0.5")));
  ExpectRead(1, ReadObj(With(kObjCube, "v 1 0 1", "v 1 0 1 1")));
}

TEST(ObjReader, NumbersOnALineOfTheirOwnAreRefused) {
  ExpectNot("line 10: begins with a number, and continues no other line",
            ReadObj(With(kObjCube, "f 1 3 4 2", "f 1 3\n4 2")));
  ExpectNot("a vertex has fewer than three numbers", ReadObj(With(kObjCube, "v 1 0 1", "v 1 0")));
}

TEST(ObjReader, PartsAreObjectsAndGroups) {
  const std::string two = "o low\n" + kObjCube +
                          "g high\nv 0 0 5\nv 1 0 5\nv 0 1 5\nv 0 0 6\n"
                          "f -4 -2 -3\nf -4 -3 -1\nf -3 -2 -1\nf -4 -1 -2\n";
  ExpectRead(1.0 + 1.0 / 6, ReadObj(two));
  ExpectRead(1.0 / 6, ReadObj(two, "high"));
  ExpectRead(1.0 / 6, ReadObj(With(two, "g high", "g high # the upper one"), "high"));
  ExpectRead(1.0 / 6, ReadObj(With(two, "g high", "g high #2"), "high #2"));
  ExpectNot("it has no part 'lid', but low, high", ReadObj(two, "lid"));
}

// Names are looked up, and not compared one by one: each has a group of its own.
TEST(ObjReader, ManyNamesTakeNoLongerThanManyLines) {
  std::string text = kObjCube;
  for (int i = 0; i < 200'000; ++i) text += "g group" + std::to_string(i) + "\n";
  ExpectRead(1, ReadObj(text));
}

TEST(ObjReader, UnitOfARemarkIsFound) {
  EXPECT_EQ(ReadObj("# File units = millimeters\n" + kObjCube).remarked_unit, 1e-3);
  EXPECT_EQ(ReadObj("#units: inches\n" + kObjCube).remarked_unit, 0.0254);
  EXPECT_EQ(ReadObj("# made in one unit\n" + kObjCube).remarked_unit, 0);
  EXPECT_EQ(ReadObj("# 4 mm holes\n" + kObjCube).remarked_unit, 0);
}

}  // namespace
}  // namespace tandem
