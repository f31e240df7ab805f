#include "app/stability/report/html_report.h"

#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/stability/report/maps.h"
#include "app/stability/report/margin_picture.h"
#include "tests/app/stability/report/made_results.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::TwentyCells;

ReportData Made() {
  ReportData data;
  data.command = "tandem stability report made --out out";
  data.version = "0.1";
  ReportSweep& sweep = data.sweeps.emplace_back();
  sweep.results = TwentyCells();
  sweep.results.records.at(19).cell.expect = Expectation::kUnstable;
  sweep.summary = Summarize(sweep.results);
  for (const StabilityMap& map : MapsOf(sweep.results, [](const LabCase&) {
         return Inertia{0.3, 8e-5 * Mat3::Identity()};
       })) {
    sweep.maps.push_back(PictureOf(map));
  }
  sweep.others.push_back(MarginPictureOf(sweep.results, "margin"));
  data.tables.push_back({"<i>table</i>", "", {"a"}, {{"1 < 2 & \"3\""}}});
  return data;
}

std::size_t Count(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

// no address, no frame, no import, nothing loaded
TEST(HtmlReport, IsSelfContained) {
  const std::string html = HtmlOf(Made());
  for (const char* word : {"http://", "https://", " src=", "url(", "@import", "<link", "<iframe",
                           "fetch(", "XMLHttp", "import("}) {
    EXPECT_THAT(html, Not(HasSubstr(word))) << word;
  }
}

TEST(HtmlReport, ElementsAreBalanced) {
  const std::string html = HtmlOf(Made());
  for (const char* name : {"html", "head", "body", "style", "script", "table", "thead", "tbody",
                           "figure", "svg", "title", "text", "div", "dl", "dt", "dd", "td", "tr"}) {
    const std::regex opened(std::string("<").append(name) + "[ >]");
    const auto begin = std::sregex_iterator(html.begin(), html.end(), opened);
    EXPECT_EQ(static_cast<std::size_t>(std::distance(begin, {})),
              Count(html, std::string("</").append(name) + ">"))
        << name;
  }
}

TEST(HtmlReport, ContainsCommandSeedVersionAndDigest) {
  const ReportData data = Made();
  const std::string html = HtmlOf(data);
  for (const std::string& fact : {data.command, std::string("tandem stability sweep made.json"),
                                  std::string("seed 3"), data.sweeps[0].summary.digest,
                                  std::string("fedcba9876543210"), std::string("tandem 0.1")}) {
    EXPECT_THAT(html, HasSubstr(fact));
  }
}

TEST(HtmlReport, HasALinkableRowPerCell) {
  const std::string html = HtmlOf(Made());
  EXPECT_EQ(Count(html, "<tr id=\"s0-"), 20U);
  EXPECT_EQ(Count(html, "<svg"), 2U);
  EXPECT_GE(Count(html, "<title>cell 7: "), 2U);  // tile and mark
}

TEST(HtmlReport, CountsPassingRowsAndMarksFailures) {
  ReportData data = Made();
  EXPECT_THAT(HtmlOf(data), HasSubstr("5 of 5 rows pass"));
  EXPECT_THAT(HtmlOf(data), Not(HasSubstr("FAIL")));
  CellRecord& control = data.sweeps[0].results.records.at(19);
  control.outcome.result.verdict = Verdict::kStable;
  data.sweeps[0].summary = Summarize(data.sweeps[0].results);
  EXPECT_THAT(HtmlOf(data), HasSubstr("4 of 5 rows pass"));
  EXPECT_THAT(HtmlOf(data), HasSubstr("<td class=\"fail\">FAIL"));
  EXPECT_THAT(HtmlOf(data), HasSubstr("<td class=\"fail\">stable"));
}

TEST(HtmlReport, EscapesText) {
  const std::string html = HtmlOf(Made());
  EXPECT_THAT(html, HasSubstr("&lt;i&gt;table&lt;/i&gt;"));
  EXPECT_THAT(html, HasSubstr("1 &lt; 2 &amp; &quot;3&quot;"));
}

// No bar stands for the boundary of a law: nothing passes, and nothing fails.
TEST(HtmlReport, WithoutClaimsSaysSo) {
  ReportData data;
  data.searches = 3;
  data.tables.push_back({"t", "", {"a"}, {{"1"}}});
  const std::string html = HtmlOf(data);
  EXPECT_THAT(html, HasSubstr("<span class=\"verdict\">the report judges no claim</span>"));
  EXPECT_THAT(html, HasSubstr("3 boundaries searched"));
  EXPECT_THAT(html, Not(HasSubstr("0 of 0")));
  EXPECT_THAT(html, Not(HasSubstr("0 experiments")));
}

}  // namespace
}  // namespace tandem
