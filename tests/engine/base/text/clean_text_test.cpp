#include "engine/base/text/clean_text.h"

#include <random>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/base/text/json_text.h"

namespace tandem {
namespace {

TEST(CleanText, LeavesTextOfAnyScriptAsItIs) {
  for (const char* text : {"", "anna", "Čeněk Žížala", "山田 太郎", "😀", "a b\u00A0c", "\uFFFD"}) {
    EXPECT_EQ(CleanText(text), text);
  }
}

TEST(CleanText, ControlAndDirectionCharactersBecomeQuestionMarks) {
  EXPECT_EQ(CleanText("a\nb\x1b[31mc\x7f"), "a?b?[31mc?");
  EXPECT_EQ(CleanText("a\u009bb\u0085"), "a?b?");           // C1: a terminal may take it for ESC [
  EXPECT_EQ(CleanText("a\u202eb\u2066c\u200f"), "a?b?c?");  // bidi: shows another name
  EXPECT_EQ(CleanText("a\u2028b"), "a?b");
}

TEST(CleanText, InvalidUtf8BecomesQuestionMarks) {
  EXPECT_EQ(CleanText("b\xff"
                      "d"),
            "b?d");
  EXPECT_EQ(CleanText("\xc3"), "?");                   // cut off
  EXPECT_EQ(CleanText("\xc0\xaf"), "??");              // overlong '/'
  EXPECT_EQ(CleanText("\xed\xa0\x80"), "???");         // half of a UTF-16 pair
  EXPECT_EQ(CleanText("\xf4\x90\x80\x80"), "????");    // beyond U+10FFFF
  EXPECT_EQ(CleanText("\xf0\x80\x80\xafx"), "????x");  // overlong
}

TEST(CleanText, OutputIsValidJsonTextAndStable) {
  std::mt19937 random(7);
  for (int i = 0; i < 100'000; ++i) {
    std::string text(random() % 12, ' ');
    for (char& c : text) c = static_cast<char>(random());
    const std::string clean = CleanText(text);
    // strict: throws at what is not UTF-8
    ASSERT_NO_THROW(nlohmann::json(clean).dump());
    ASSERT_EQ(CleanText(clean), clean);
  }
}

TEST(JsonText, NeverThrowsOnAString) {
  const nlohmann::json json{{"name", "b\xff"}};
  ASSERT_THROW(json.dump(), nlohmann::json::type_error);
  EXPECT_EQ(JsonText(json), "{\"name\":\"b\uFFFD\"}");
}

TEST(CleanText, LinesKeepTheirEnds) {
  EXPECT_EQ(CleanLines("a\x1b\nb\r\n\n"), "a?\nb?\n\n");
  EXPECT_EQ(CleanLines(""), "");
}

// a reader must find the same string, and a terminal nothing that it obeys
TEST(JsonText, EscapesWhatATerminalObeys) {
  for (const char* text : {"a\x7f", "a\u009b2J", "a\u202eb", "a\u2028b", "a\u2066b\u200f", "\u061c",
                           "山田 😀 é", "\x1b]0;x\x07\n"}) {
    const std::string json = JsonText(nlohmann::json{{"name", text}});
    EXPECT_EQ(CleanText(json), json);
    EXPECT_EQ(nlohmann::json::parse(json).at("name"), text);
  }
  EXPECT_EQ(JsonText(nlohmann::json("山田 😀 é")), "\"山田 😀 é\"");
}

}  // namespace
}  // namespace tandem
