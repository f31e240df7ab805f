#include "engine/base/json_reader.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(JsonFile, OfATextNamesTheFaultByTheGivenName) {
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

TEST(JsonNode, GivesBackWhatItHoldsOnOneLineWithItsKeysInOrder) {
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

}  // namespace
}  // namespace tandem
