// Tests STL files as programs write them: text in any case and layout, binary with counts that do
// not fit. A text is a tetrahedron of volume 1/6, a binary file a cube of side 1.
#include <array>
#include <cctype>
#include <string>

#include <gtest/gtest.h>

#include "engine/geometry/formats/native_readers.h"
#include "tests/engine/geometry/formats/misread_files.h"
#include "tests/engine/geometry/formats/read_answers.h"

namespace tandem {
namespace {

using testing::Bytes;
using testing::ExpectNot;
using testing::ExpectRead;
using testing::ExpectReadWith;
using testing::MisreadFiles;
using testing::With;

std::string StlFacet(const std::string& a, const std::string& b, const std::string& c) {
  return " facet normal 0 0 1\n  outer loop\n   vertex " + a + "\n   vertex " + b + "\n   vertex " +
         c + "\n  endloop\n endfacet\n";
}

const std::string kStlTetrahedron =
    "solid part\n" + StlFacet("0 0 0", "0 1 0", "1 0 0") + StlFacet("0 0 0", "1 0 0", "0 0 1") +
    StlFacet("1 0 0", "0 1 0", "0 0 1") + StlFacet("0 0 0", "0 0 1", "0 1 0") + "endsolid part\n";

std::string Changed(std::string text, int (*change)(int)) {
  for (char& c : text) c = static_cast<char>(change(static_cast<unsigned char>(c)));
  return text;
}

std::string WithAll(std::string text, const std::string& old, const std::string& words) {
  for (std::size_t at = text.find(old); at != std::string::npos;
       at = text.find(old, at + words.size())) {
    text.replace(at, old.size(), words);
  }
  return text;
}

TEST(StlReader, TextIsReadInAnyCaseAndLayout) {
  ExpectRead(1.0 / 6, ReadStl(kStlTetrahedron));
  ExpectRead(1.0 / 6, ReadStl(Changed(kStlTetrahedron, std::toupper)));
  ExpectRead(1.0 / 6, ReadStl("\n\n \t\n" + kStlTetrahedron));
  ExpectRead(1.0 / 6, ReadStl(WithAll(kStlTetrahedron, "\n", "\r\n")));
  ExpectRead(1.0 / 6, ReadStl(WithAll(kStlTetrahedron, "\n", "\r")));
  ExpectRead(1.0 / 6, ReadStl(WithAll(kStlTetrahedron, "\n", "\n\n")));
  ExpectRead(1.0 / 6, ReadStl("solid part " + WithAll(kStlTetrahedron.substr(11), "\n", " ")));
  ExpectRead(1.0 / 6, ReadStl(WithAll(kStlTetrahedron, "vertex ", "vertex\n")));
  ExpectRead(1.0 / 6, ReadStl(WithAll(kStlTetrahedron, "endloop", "end loop")));
  ExpectRead(1.0 / 6, ReadStl(WithAll(kStlTetrahedron, "outer loop", "outerloop")));
  ExpectRead(1.0 / 6, ReadStl(kStlTetrahedron + "\x1a"));
}

TEST(StlReader, RemarksAndNamesOfAnyWordsAreSkipped) {
  ExpectRead(1.0 / 6, ReadStl(WithAll(kStlTetrahedron, "0 0 1\n", "0 0 1 # up\n")));
  ExpectRead(1.0 / 6, ReadStl("# made by hand\n" + kStlTetrahedron));
  ExpectRead(1.0 / 6,
             ReadStl(WithAll(kStlTetrahedron, "solid part", "solid facet of vertex 5.stl")));
  ExpectRead(1.0 / 6, ReadStl(WithAll(kStlTetrahedron, "solid part", "solid")));
}

TEST(StlReader, NormalsDoNotCount) {
  for (const char* normal : {"0 0 0", "nan nan nan", "-nan(ind) 1.#QNAN 0", "0,5 0 1", ""}) {
    ExpectRead(1.0 / 6,
               ReadStl(WithAll(kStlTetrahedron, "normal 0 0 1", std::string("normal ") + normal)));
  }
}

TEST(StlReader, WordsThatAreNoNumbersAreRefused) {
  for (const std::string word : {"1mm", "1,0", "1.0-1", "one"}) {
    ExpectNot("'" + word + "' is not a number",
              ReadStl(WithAll(kStlTetrahedron, "vertex 1", "vertex " + word)));
  }
  ExpectRead(1.0 / 6, ReadStl(WithAll(kStlTetrahedron, "vertex 1", "vertex 1.0D+00")));
}

TEST(StlReader, TextThatEndsEarlyIsToldOrRefused) {
  ExpectReadWith(1.0 / 6, "it has no endsolid behind facet 4",
                 ReadStl(With(kStlTetrahedron, "endsolid part\n", "")));
  ExpectNot("it ends within facet 4: it is cut short",
            ReadStl(kStlTetrahedron.substr(0, kStlTetrahedron.rfind("endloop"))));
  ExpectNot("a facet has 2 vertices in place of three",
            ReadStl(With(kStlTetrahedron, "   vertex 0 1 0\n", "")));
}

std::string OnOneLine(const std::string& name) {
  return "solid " + name + " " +
         WithAll(kStlTetrahedron.substr(11, kStlTetrahedron.size() - 25), "\n", " ") + "endsolid ";
}

TEST(StlReader, SolidsOnOneLineAreAllRead) {
  ExpectRead(2.0 / 6, ReadStl(OnOneLine("a") + "a " + OnOneLine("b") + "b\n"));
  ExpectRead(2.0 / 6, ReadStl(OnOneLine("a") + OnOneLine("b")));
  ExpectRead(3.0 / 6,
             ReadStl(OnOneLine("a") + OnOneLine("my solid") + "my solid " + OnOneLine("c") + "c"));
  ExpectRead(1.0 / 6, ReadStl(OnOneLine("a") + "a " + OnOneLine("b"), "b"));
  ExpectRead(1.0 / 6, ReadStl(OnOneLine("a") + "a solid piece"));
  // facets without a solid of their own
  ExpectRead(2.0 / 6, ReadStl(OnOneLine("a") + "a " + OnOneLine("").substr(7)));
}

// A reader that looks at the whole rest of the line for each facet takes minutes.
TEST(StlReader, OneLongLineTakesNoLongerThanManyLines) {
  std::string facets;
  std::string solids;
  for (int i = 0; i < 5'000; ++i) facets += kStlTetrahedron.substr(11, kStlTetrahedron.size() - 25);
  for (int i = 0; i < 5'000; ++i) solids += OnOneLine("a") + "a ";
  const ReadAnswer one = ReadStl("solid a " + WithAll(std::move(facets), "\n", " ") + "endsolid");
  ASSERT_EQ(one.kind, ReadAnswer::Kind::kMesh) << one.words;
  EXPECT_EQ(one.mesh.triangles.size(), 20'000U);
  EXPECT_EQ(ReadStl(solids).mesh.triangles.size(), 20'000U);
}

TEST(StlReader, SeveralLoopsInAFacetAreRefused) {
  ExpectNot("a facet has several loops",
            ReadStl(With(kStlTetrahedron, "endloop\n",
                         "endloop\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 "
                         "1\nendloop\n")));
}

TEST(StlReader, SolidsAreParts) {
  const std::string two = kStlTetrahedron + WithAll(kStlTetrahedron, "part", "lid of a box");
  ExpectRead(2.0 / 6, ReadStl(two));
  ExpectRead(1.0 / 6, ReadStl(two, "lid of a box"));
  ExpectNot("it has no part 'cup', but part, lid of a box", ReadStl(two, "cup"));
}

// ---- binary ----

std::string StlOfCount(std::uint32_t count) {
  std::string cube = testing::BinaryStlCube();
  return cube.replace(80, 4, Bytes(count, 4));
}

TEST(StlReader, CountThatTheProgramDidNotKnowIsTakenFromTheLength) {
  ExpectRead(1, ReadStl(StlOfCount(12)));
  ExpectReadWith(1, "its head says that it has 0 triangles, and its length is that of 12",
                 ReadStl(StlOfCount(0)));
  ExpectReadWith(1, "its length is that of 12: 12 are read", ReadStl(StlOfCount(0xffffffff)));
  ExpectReadWith(1, "its head says that it has 4 triangles, and its length is that of 12: 12 are",
                 ReadStl(StlOfCount(4)));
}

TEST(StlReader, BinaryFileHasNoParts) {
  ExpectNot("it has no part 'lid', for a binary file has none: leave \"part\" out",
            ReadStl(StlOfCount(12), "lid"));
}

// Such a text has the length of a binary file now and then.
TEST_F(MisreadFiles, StlTextInUtf16IsTextWhateverItsLength) {
  for (std::size_t blanks = 0; blanks < 25; ++blanks) {
    std::string wide = "\xFF\xFE";
    for (const char c : kStlTetrahedron + std::string(blanks, ' ')) wide += {c, '\0'};
    ExpectVolume(1.0 / 6, "wide.stl", wide);
  }
}

TEST(StlReader, CountBeyondTheLengthIsRefused) {
  ExpectNot("its head says that it has 13 triangles, and its length is that of 12: it is cut short",
            ReadStl(StlOfCount(13)));
  ExpectNot("it is cut short", ReadStl(StlOfCount(12).substr(0, 84 + 50 * 11 + 20)));
  ExpectNot("nor as long as the head of a binary file", ReadStl(StlOfCount(12).substr(0, 70)));
}

TEST(StlReader, WhatStandsBehindTheTrianglesIsTold) {
  ExpectRead(1, ReadStl(StlOfCount(12) + std::string(50, '\0')));
  ExpectReadWith(1, "9 bytes behind its triangles are not read",
                 ReadStl(StlOfCount(12) + "9 letters"));
}

TEST(StlReader, FilesOneBehindTheOtherAreAllRead) {
  ExpectRead(2, ReadStl(StlOfCount(12) + StlOfCount(12)));
  ExpectRead(3, ReadStl(StlOfCount(12) + StlOfCount(12) + StlOfCount(12) + "\n"));
}

TEST(StlReader, NumbersInTheOtherByteOrderAreRead) {
  std::string cube = StlOfCount(12);
  std::string turned = cube.substr(0, 80);
  const auto add = [&](std::size_t at) {
    for (std::size_t i = 4; i > 0; --i) turned += cube[at + i - 1];
  };
  add(80);
  for (std::size_t t = 0; t < 12; ++t) {
    for (std::size_t n = 0; n < 12; ++n) add(84 + 50 * t + 4 * n);
    turned += cube.substr(84 + 50 * t + 48, 2);
  }
  ExpectRead(1, ReadStl(turned));
}

}  // namespace
}  // namespace tandem
