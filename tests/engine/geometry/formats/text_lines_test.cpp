#include "engine/geometry/formats/text_lines.h"

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(TextLines, EndInAnyOfTheThreeWays) {
  TextLines lines("a\nb\r\n\rc");
  std::vector<std::string> all;
  for (std::string_view line; lines.Next(line);) all.emplace_back(line);
  EXPECT_EQ(all, (std::vector<std::string>{"a", "b", "", "c"}));
  EXPECT_EQ(lines.number(), 4U);
}

TEST(TextLines, UnitsAreFoundInRemarksOnUnitsOnly) {
  EXPECT_EQ(UnitOfRemark("# Units: mm"), 1e-3);
  EXPECT_EQ(UnitOfRemark("comment file units = inches"), 0.0254);
  EXPECT_EQ(UnitOfRemark("# unit cm"), 1e-2);
  EXPECT_EQ(UnitOfRemark("# units are in meters"), 1);
  EXPECT_EQ(UnitOfRemark("# 5 mm wide"), 0);
  EXPECT_EQ(UnitOfRemark("# made by the unit of Mr Foot"), 0.3048)
      << "a remark only, which is told";
  EXPECT_EQ(UnitOfRemark(""), 0);
}

TEST(TextLines, PercentCodesStandForBytes) {
  EXPECT_EQ(WithoutPercents("a%20b%C3%a4.bin"), "a b\xC3\xA4.bin");
  EXPECT_EQ(WithoutPercents("100%"), "100%");
  EXPECT_EQ(WithoutPercents("100%2"), "100%2");
  EXPECT_EQ(WithoutPercents("%zz"), "%zz");
  EXPECT_EQ(WithoutPercents("%2525"), "%25");
}

TEST(TextLines, Utf16BecomesUtf8) {
  // a, a-umlaut, the euro, a clef beyond 16 bits
  EXPECT_EQ(InUtf8(std::string("\xFF\xFE"
                               "a\0\xE4\0\xAC\x20\x34\xD8\x1E\xDD",
                               12)),
            "a\xC3\xA4\xE2\x82\xAC\xF0\x9D\x84\x9E");
  EXPECT_EQ(InUtf8(std::string("\xFE\xFF\xD8\x34", 4)), "?");  // half a character
  EXPECT_EQ(InUtf8(std::string("<\0a\0", 4)), "<a");
  EXPECT_EQ(InUtf8("\xEF\xBB\xBFplain"), "plain");
}

}  // namespace
}  // namespace tandem
