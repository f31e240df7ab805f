#include "app/picture/picture_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/picture/svg.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;

class PictureFileTest : public ::testing::Test {
 protected:
  Result<std::vector<Picture>> Read(const std::string& text) const {
    return ReadPictures(folder_.Write("pictures.json", text));
  }
  std::string WrongIn(const std::string& text) const {
    const auto pictures = Read(text);
    return pictures ? "nothing is wrong" : pictures.error().what;
  }

  ScratchFolder folder_;
};

TEST_F(PictureFileTest, RoundTrips) {
  Picture picture{"map", "a map", 200, 100, {}};
  picture.shapes.emplace_back(
      RectangleShape{{10, 20, 30.125, 40}, Rgb{255, 128, 0}, Stroke{kBlack, 0.5, {}}, {}});
  picture.shapes.emplace_back(PolylineShape{{{0, 0}, {10.5, 20}}, {Rgb{1, 2, 3}, 2, {4, 3}}});
  picture.shapes.emplace_back(MarkerShape{{50, 60}, MarkerKind::kRing, 6, kBlack, {}});
  picture.shapes.emplace_back(
      LabelShape{{5, 90}, "k \"<\" \xCF\x84", 12, TextAnchor::kEnd, kBlack, true, true});
  const auto read = Read(JsonOf(std::vector<Picture>{picture, Picture{"b", "t", 1, 1, {}}}));
  ASSERT_TRUE(read) << read.error().what;
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[0].name, "map");
  EXPECT_EQ(SvgOf((*read)[0], SvgPlace::kFile), SvgOf(picture, SvgPlace::kFile));
}

TEST_F(PictureFileTest, ReportsTheFirstError) {
  EXPECT_THAT(WrongIn("{"), HasSubstr("pictures.json"));
  EXPECT_THAT(WrongIn(R"({"pictures": [{"name": "../a", "title": "t", "width": 9, "height": 9,
                          "shapes": []}]})"),
              HasSubstr("pictures[0].name: expected a plain file name"));
  EXPECT_THAT(WrongIn(R"({"pictures": [{"name": "a", "title": "t", "width": 1e9, "height": 9,
                          "shapes": []}]})"),
              HasSubstr("at most 20000 pixels"));
  EXPECT_THAT(WrongIn(R"({"pictures": [{"name": "a", "title": "t", "width": 9, "height": 9,
                          "shapes": [{"marker": {"at": [1], "kind": "star", "size": 1,
                          "colour": "red"}}]}]})"),
              HasSubstr("shapes[0].marker"));
}

}  // namespace
}  // namespace tandem
