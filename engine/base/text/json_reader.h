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
/// something other than the expected value, the node notes the file's first fault and returns a
/// harmless value. The reader goes on: check JsonFile::fault() once, at the end.
class JsonNode {
 public:
  /// Tells whether an object has this key.
  bool Has(std::string_view key) const;
  /// Returns an object's value under this key. A missing value is a fault when it is read.
  JsonNode operator[](std::string_view key) const;
  /// Returns the values of an array.
  std::vector<JsonNode> Items() const;
  bool IsArray() const;
  bool IsObject() const;
  /// Returns all of it on one line, keys in order; "null" when missing.
  std::string Compact() const;

  /// Makes any other key of this object a fault, so that a misspelt key does not go unnoticed.
  void AllowKeys(std::initializer_list<std::string_view> keys) const;

  /// Returns plain text: without control characters, valid UTF-8, at most 64 KiB.
  std::string Text(std::string_view expected = "text") const;
  /// Returns the same, of at most `most` bytes, and possibly empty.
  std::string PlainText(std::size_t most) const;
  bool TrueOrFalse() const;
  double Number() const;
  double NumberAbove(double limit) const;
  double NumberFrom(double least) const;
  double NumberBetween(double least, double most) const;  // limits included
  int WholeNumber(int least, int most) const;
  std::uint64_t Unsigned(std::uint64_t most = UINT64_MAX) const;
  Vec3 Vector() const;    // [x, y, z]
  Quat Rotation() const;  // [x, y, z, w] of length 1 within 0.1 %; comes back normalized

  /// Notes a fault at this place: "expected `expected`, got" and the value there.
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

/// A JSON file in memory. It may come from an untrusted source. Read() refuses a file that is not
/// regular or is larger than 64 MiB. It also refuses more than two million values, or brackets
/// deeper than 64, before it parses.
class JsonFile {
 public:
  /// Reads a file. A syntax error names the line and the column. A key given twice is an error too.
  static Result<JsonFile> Read(const std::filesystem::path& file);
  /// Does the same for a text; `name` stands for the file in errors.
  static Result<JsonFile> Parse(const std::string& text, const std::string& name);

  JsonNode root() const;
  /// Returns the first fault noted by its nodes: `FILE: PLACE: WHAT`.
  std::optional<Error> fault() const;

 private:
  explicit JsonFile(std::shared_ptr<JsonNode::Content> content);
  std::shared_ptr<JsonNode::Content> content_;
};

}  // namespace tandem
