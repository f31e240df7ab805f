#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tandem {

/// Goes through XML, piece by piece, and keeps nothing, so that its memory depends neither on depth
/// nor on size. It knows only the five entities of XML and numeric ones, so that no text grows. It
/// is for files whose content is checked by its meaning; it checks that as many elements close as
/// open, and not in which order.
class XmlScanner {
 public:
  enum class Piece { kOpen, kClose, kText, kEnd, kFault };

  /// `text` must outlive the scanner.
  explicit XmlScanner(std::string_view text);

  Piece Next();
  /// Returns the name of an element that was opened or closed, without its prefix.
  std::string_view name() const noexcept { return name_; }
  /// Returns the prefix of that name, as written; empty: it has none.
  std::string_view prefix() const noexcept { return prefix_; }
  /// Returns the attribute of that name of an element that was opened: the one without a prefix, or
  /// else the first with any.
  std::optional<std::string> Attribute(std::string_view name) const;
  /// Returns the attribute of that name as written, with its prefix.
  std::optional<std::string> AttributeAsWritten(std::string_view name) const;
  /// Returns all attributes of an element that was opened: names as written, and values.
  std::vector<std::pair<std::string, std::string>> Attributes() const;
  /// Returns a text, as written.
  std::string_view text() const noexcept { return text_; }
  /// Tells whether the element that was opened is empty: `<a/>`. No kClose follows.
  bool empty() const noexcept { return empty_; }

 private:
  Piece ReadTag();
  bool ReadAttributes(std::string_view tag);
  bool SkipUpTo(std::string_view words);

  std::string_view rest_;
  std::string_view name_;
  std::string_view prefix_;
  std::string_view text_;
  std::vector<std::pair<std::string_view, std::string_view>> attributes_;
  bool empty_ = false;
  std::int64_t depth_ = 0;  // elements that are open
};

}  // namespace tandem
