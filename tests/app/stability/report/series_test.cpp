#include "app/stability/report/series.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/picture/svg.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;

// two users for 12 s at 100 Hz, with one peak of 80 N
Series TwelveSeconds() {
  Series series;
  series.columns = {"t_s"};
  for (const char* column :
       {"apart_mm", "v1_mm_s", "force1_N", "link1_N", "stiffness1_N_m", "loop1_ms", "v2_mm_s",
        "force2_N", "link2_N", "stiffness2_N_m", "loop2_ms"}) {
    series.columns.emplace_back(column);
  }
  series.values.resize(series.columns.size());
  for (int i = 0; i < 1200; ++i) {
    const double t = 0.01 * i;
    series.values[0].push_back(t);
    for (std::size_t column = 1; column < series.columns.size(); ++column) {
      series.values[column].push_back(20 * std::exp(-t) *
                                      std::abs(std::sin(t + 0.1 * double(column))));
    }
  }
  series.values[3][700] = 80;
  return series;
}

TEST(Series, RoundTrips) {
  const ScratchFolder folder;
  const auto file = folder.Write("a.csv", "t_s,apart_mm,v1_mm_s\n0,1.5,\n0.01,2e-3,7\n");
  const auto series = ReadSeries(file);
  ASSERT_TRUE(series) << series.error().what;
  ASSERT_NE(series->Column("apart_mm"), nullptr);
  EXPECT_EQ(*series->Column("apart_mm"), (std::vector<double>{1.5, 2e-3}));
  EXPECT_TRUE(std::isnan(series->Column("v1_mm_s")->at(0)));
  EXPECT_EQ(series->Column("v2_mm_s"), nullptr);
}

TEST(Series, ErrorsNameTheInvalidLine) {
  const ScratchFolder folder;
  const auto word = ReadSeries(folder.Write("a.csv", "t_s,x\n0,1\n1,fast\n"));
  ASSERT_FALSE(word);
  EXPECT_THAT(word.error().what, HasSubstr("line 3: expected a number, got \"fast\""));
  const auto cut = ReadSeries(folder.Write("b.csv", "t_s,x\n0\n"));
  ASSERT_FALSE(cut);
  EXPECT_THAT(cut.error().what, HasSubstr("line 2: expected 2 values, got 1"));
}

// A refusal is one line without control characters.
void ExpectRefused(const Result<Series>& series, const std::string& why) {
  ASSERT_FALSE(series) << why;
  EXPECT_THAT(series.error().what, HasSubstr(why));
  for (const char c : series.error().what) {
    EXPECT_GE(static_cast<unsigned char>(c), 0x20) << series.error().what;
  }
}

TEST(Series, AbsurdFilesAreRefusedInOneLine) {
  const ScratchFolder folder;
  const auto read = [&folder](const std::string& text) {
    return ReadSeries(folder.Write("s.csv", text));
  };
  // numbers that no double holds, which must not pass for a missing value
  for (const std::string number : {"1e309", "-1e309", "1e-400", "inf", "-inf", "infinity", "nan(1)",
                                   "0x10", "+1", " 1", "1 ", "1;2", "--1"}) {
    ExpectRefused(read("t_s,x\n0," + number + "\n"), "line 2: expected a number, got");
  }
  const auto large = read("t_s,x\n-1e308,1e308\n");
  ASSERT_TRUE(large) << large.error().what;
  EXPECT_EQ(large->values[1][0], 1e308);
  ExpectRefused(read("t_s,x\n0,\x1b]0;owned\x07\n"), "line 2: expected a number, got");
  ExpectRefused(read("t_s,x\n0,=1+1\n"), "line 2: expected a number, got");
  ExpectRefused(read(std::string("t_s,x\n0,1\0\n", 11)), "line 2: expected a number, got");
  ExpectRefused(read("t_s,x,x\n0,1,2\n"), "line 1: two columns have one name");
  ExpectRefused(read(""), "cannot be read");
  ExpectRefused(read(std::string(100'000, 'x')), "cannot be read");
  ExpectRefused(read("t_s\n" + std::string(100'000, '1') + "\n"), "has a line that no case writes");
}

// A line of 64 kB names 30,000 columns: each row takes their numbers.
TEST(Series, ManyColumnsTakeBoundedMemory) {
  const ScratchFolder folder;
  std::string text = "0";
  for (int i = 1; i < 11'000; ++i) text += "," + std::to_string(i);
  text += '\n';
  for (int row = 0; row < 2800; ++row) text += std::string(10'999, ',') + '\n';
  ExpectRefused(ReadSeries(folder.Write("wide.csv", text)), "more numbers than any case writes");
}

TEST(SeriesPicture, AbsurdValuesMakeABoundedPicture) {
  Series series = TwelveSeconds();
  series.values[0] = std::vector<double>(series.values[0].size(), -1e308);
  for (std::size_t column = 1; column < series.columns.size(); ++column) {
    for (std::size_t i = 0; i < series.values[column].size(); ++i) {
      series.values[column][i] = i % 3 == 0 ? 1e308 : i % 3 == 1 ? -1e308 : std::nan("");
    }
  }
  const std::string svg = SvgOf(PictureOf(series, "absurd", "absurd", ""), SvgPlace::kFile);
  EXPECT_LT(svg.size(), 400'000U);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(Series, ThinningKeepsEveryPeak) {
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 0; i < 40'000; ++i) {
    x.push_back(1e-3 * i);
    y.push_back(std::sin(1e-3 * i));
  }
  y[12'345] = 9;
  y[23'456] = -7;
  const std::vector<PicturePoint> points = Thinned(x, y, 200);
  EXPECT_LE(points.size(), 400U);
  const auto [least, greatest] = std::ranges::minmax(points, {}, &PicturePoint::y);
  EXPECT_EQ(least.y, -7);
  EXPECT_EQ(least.x, 23.456);
  EXPECT_EQ(greatest.y, 9);
  EXPECT_EQ(greatest.x, 12.345);
  EXPECT_TRUE(std::ranges::is_sorted(points, {}, &PicturePoint::x));
}

TEST(SeriesPicture, TextsDoNotOverlapAndUnitsAreShown) {
  const Picture picture = PictureOf(TwelveSeconds(), "cell-1", "cell 1: free", "worst tail");
  std::vector<LabelShape> labels;
  std::string texts;
  for (const PictureShape& shape : picture.shapes) {
    if (const auto* label = std::get_if<LabelShape>(&shape)) {
      labels.push_back(*label);
      texts += label->text + '\n';
    }
  }
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const PictureBox box = BoundsOf(labels[i]);
    EXPECT_TRUE(box.x >= 0 && box.right() <= picture.width) << labels[i].text;
    EXPECT_TRUE(box.y >= 0 && box.bottom() <= picture.height) << labels[i].text;
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_FALSE(box.Overlaps(BoundsOf(labels[j]))) << labels[i].text << " on " << labels[j].text;
    }
  }
  for (const char* unit : {"apart, mm", "speed, mm/s", "force, N", "stiffness, N/m", "loop age, ms",
                           "loops are closed, s"}) {
    EXPECT_THAT(texts, HasSubstr(unit));
  }
  EXPECT_THAT(texts, HasSubstr("80"));  // the axis of forces reaches to the peak
}

TEST(SeriesPicture, LongTitleFits) {
  const std::string title =
      "cell 573: free, 2 users, hands relaxed, 100 ms, clean, 1000 Hz, constant 100 N/m + 10 N "
      "s/m, forces exchanged, kick";
  const Picture picture = PictureOf(TwelveSeconds(), "cell-573", title, "worst tail");
  const auto& label = std::get<LabelShape>(picture.shapes.front());
  ASSERT_EQ(label.text, title);
  EXPECT_LE(BoundsOf(label).right(), picture.width);
  EXPECT_GE(label.size, 10);
}

TEST(SeriesPicture, FileSizeIsBoundedForLongRuns) {
  Series series = TwelveSeconds();
  for (std::vector<double>& column : series.values) {
    const std::vector<double> once = column;
    for (int i = 0; i < 30; ++i) column.insert(column.end(), once.begin(), once.end());
  }
  EXPECT_LT(SvgOf(PictureOf(series, "a", "t", "n"), SvgPlace::kFile).size(), 150'000U);
}

}  // namespace
}  // namespace tandem
