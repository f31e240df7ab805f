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
