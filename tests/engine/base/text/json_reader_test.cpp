#include "engine/base/text/json_reader.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(JsonFile, ParseErrorsUseTheGivenName) {
  const Result<JsonFile> broken = JsonFile::Parse("{\"a\": 1,,}", "cell 3");
  ASSERT_FALSE(broken);
  EXPECT_EQ(broken.error().what.rfind("cell 3: line 1, column 9", 0), 0U) << broken.error().what;

  const Result<JsonFile> twice = JsonFile::Parse(R"({"a": 1, "a": 2})", "cell 4");
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().what, "cell 4: the key \"a\" is given twice");

  const Result<JsonFile> wrong = JsonFile::Parse(R"({"a": [1, "x"]})", "cell 5");
  ASSERT_TRUE(wrong);
  wrong->root()["a"].Items()[1].Number();
  ASSERT_TRUE(wrong->fault());
  EXPECT_EQ(wrong->fault()->what, "cell 5: a[1]: expected a number, got \"x\"");
}

TEST(JsonNode, PrintsOnOneLineWithKeysInOrder) {
  const Result<JsonFile> file =
      JsonFile::Parse("{\"z\": [1, 0.5,\n true], \"a\": {\"y\": null, \"b\": \"c\"}}", "text");
  ASSERT_TRUE(file);
  EXPECT_EQ(file->root().Compact(), R"({"a":{"b":"c","y":null},"z":[1,0.5,true]})");
  EXPECT_EQ(file->root()["z"].Compact(), "[1,0.5,true]");
  EXPECT_EQ(file->root()["none"].Compact(), "null");
  EXPECT_TRUE(file->root()["z"].IsArray());
  EXPECT_FALSE(file->root()["a"].IsArray());
  EXPECT_FALSE(file->root()["none"].IsArray());
  EXPECT_FALSE(file->fault());
}

// A parser that goes down with each bracket needs stack for it, and so does the code that frees the
// value.
TEST(JsonFile, RefusesDeepNesting) {
  EXPECT_TRUE(JsonFile::Parse(std::string(60, '[') + std::string(60, ']'), "deep.json"));
  for (const char open : {'[', '{'}) {
    const auto deep = JsonFile::Parse("\n" + std::string(150'000, open), "deep.json");
    ASSERT_FALSE(deep);
    EXPECT_EQ(deep.error().what,
              "deep.json: line 2: more than 64 brackets in one another: this is no file of "
              "Tandem's");
  }
  // brackets in a text are none
  EXPECT_TRUE(JsonFile::Parse("[\"" + std::string(100, '[') + "\"]", "text.json"));
}

TEST(JsonFile, RefusesTooManyValues) {
  std::string many = "[0";
  for (int i = 0; i < 2'000'001; ++i) many += ",0";
  const auto file = JsonFile::Parse(many + "]", "many.json");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().what,
            "many.json: line 1: more than 2000000 values: this is no file of Tandem's");
}

TEST(JsonFile, MessageIsOnePlainLine) {
  const auto file = JsonFile::Parse(R"({"na\u001b[31m\nme": 1})", "red.json");
  ASSERT_TRUE(file);
  file->root().AllowKeys({"name"});
  ASSERT_TRUE(file->fault());
  EXPECT_EQ(file->fault()->what, "red.json: na?[31m me: unknown key; known here are name");
  const auto name = JsonFile::Parse(R"({"name": "\u001b]0;title\u0007"})", "bell.json");
  EXPECT_EQ(name->root()["name"].Text(), "");
  EXPECT_EQ(name->fault()->what, "bell.json: name: has a control character: leave it out");
  // a word as long as a file is not compared letter by letter with those that are known
  const auto key = JsonFile::Parse("{\"" + std::string(1 << 20, 'x') + "\": 1}", "long.json");
  key->root().AllowKeys({"name"});
  EXPECT_LT(key->fault()->what.size(), 400U);
}

}  // namespace
}  // namespace tandem
