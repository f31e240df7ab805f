#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tandem {

/// Goes through XML, piece by piece, and keeps nothing: neither depth nor size bears on its memory.
/// Knows no entities but the five of XML and those by number, so that nothing grows. It is for
/// files whose content is checked by what they mean; whether elements close in order is not looked
/// at.
class XmlScanner {
 public:
  enum class Piece { kOpen, kClose, kText, kEnd, kFault };

  /// `text` must outlive the scanner.
  explicit XmlScanner(std::string_view text);

  Piece Next();
  /// Of an element that was opened or closed, without its prefix.
  std::string_view name() const noexcept { return name_; }
  /// Of an element that was opened: its attribute of that name, without a prefix.
  std::optional<std::string> Attribute(std::string_view name) const;
  /// The same of an attribute by its name as it stands there, with its prefix.
  std::optional<std::string> AttributeAsWritten(std::string_view name) const;
  /// Of a text, as it stands there.
  std::string_view text() const noexcept { return text_; }
  /// Whether the element that was opened has nothing in it: `<a/>`. No kClose follows.
  bool empty() const noexcept { return empty_; }

 private:
  Piece ReadTag();
  bool ReadAttributes(std::string_view tag);
  bool SkipUpTo(std::string_view words);

  std::string_view rest_;
  std::string_view name_;
  std::string_view text_;
  std::vector<std::pair<std::string_view, std::string_view>> attributes_;
  bool empty_ = false;
};

}  // namespace tandem
