#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.h"
#include "engine/base/spatial.h"

namespace tandem {

/// One value in a JSON file, with its place there (`bodies[1].mass_kg`). Where the file holds
/// something else than what is asked for, the file's first such fault is kept, harmless values are
/// given back, and the reader goes on: check JsonFile::fault() once, at the end.
class JsonNode {
 public:
  /// Of an object: does it have this key?
  bool Has(std::string_view key) const;
  /// Of an object: its value under this key. A missing one is told of when it is read.
  JsonNode operator[](std::string_view key) const;
  /// Of an array: its values.
  std::vector<JsonNode> Items() const;
  bool IsArray() const;
  bool IsObject() const;
  /// All of it on one line, keys in order; "null" when missing.
  std::string Compact() const;

  /// Makes any other key of this object a fault, so that a misspelt one is not passed over.
  void AllowKeys(std::initializer_list<std::string_view> keys) const;

  /// Of plain text: without control characters, valid UTF-8, at most 64 KiB.
  std::string Text(std::string_view expected = "text") const;
  /// The same, of at most `most` bytes, and empty too.
  std::string PlainText(std::size_t most) const;
  bool TrueOrFalse() const;
  double Number() const;
  double NumberAbove(double limit) const;
  double NumberFrom(double least) const;
  double NumberBetween(double least, double most) const;  // with both
  int WholeNumber(int least, int most) const;
  std::uint64_t Unsigned(std::uint64_t most = UINT64_MAX) const;
  Vec3 Vector() const;    // [x, y, z]
  Quat Rotation() const;  // [x, y, z, w] of length 1 within 0.1 %; comes back normalized

  /// Notes a fault at this place: "expected `expected`, got" and what stands there.
  void Expected(std::string_view expected) const;
  /// Notes a fault at this place in the caller's words.
  void Fault(const std::string& what) const;

 private:
  friend class JsonFile;
  struct Content;
  JsonNode(std::shared_ptr<Content> content, const void* value, std::string place);
  double NumberWhere(bool (*good)(double, double), double limit, const std::string& expected) const;

  std::shared_ptr<Content> content_;
  const void* value_;  // nlohmann::json, null when missing
  std::string place_;
};

/// A JSON file in memory. A stranger may have written it: a file that is not regular, larger than
/// 64 MiB, of more than two million values or of brackets deeper than 64 is refused before it is
/// parsed.
class JsonFile {
 public:
  /// An error of syntax tells the line and the column. A key given twice is an error too.
  static Result<JsonFile> Read(const std::filesystem::path& file);
  /// The same of a text; `name` stands for the file in what is said of it.
  static Result<JsonFile> Parse(const std::string& text, const std::string& name);

  JsonNode root() const;
  /// The first fault noted by its nodes: `FILE: PLACE: WHAT`.
  std::optional<Error> fault() const;

 private:
  explicit JsonFile(std::shared_ptr<JsonNode::Content> content);
  std::shared_ptr<JsonNode::Content> content_;
};

/// The word nearest to `word` by edit distance, if near enough to be a slip of the hand; else
/// empty.
std::string_view NearestWord(std::string_view word, const std::vector<std::string_view>& words);

}  // namespace tandem
