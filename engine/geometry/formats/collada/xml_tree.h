#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/result.h"

namespace tandem {

/// An element of an XML text, without its prefix, with all that is in it.
struct XmlElement {
  std::string name;
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<std::string_view> texts;  // within the text that was parsed
  std::vector<std::unique_ptr<XmlElement>> children;

  /// Returns the attribute of that name; empty: there is none.
  std::string Attribute(std::string_view name) const;
  bool HasAttribute(std::string_view name) const;
  /// Returns the first child of that name; null: there is none.
  const XmlElement* Child(std::string_view name) const;
  std::vector<const XmlElement*> Children(std::string_view name) const;
  /// Returns all its text, in words.
  std::vector<std::string_view> Words() const;
};

/// An XML text as a tree, which must not outlive the text.
class XmlTree {
 public:
  /// Parses a text. The error continues the file's name: it is not whole, or is nested too deep.
  static Result<XmlTree> Parse(std::string_view text);

  const XmlElement& root() const { return *root_; }
  /// Returns the elements of an id, which should be one.
  std::vector<const XmlElement*> ById(std::string_view id) const;

 private:
  std::unique_ptr<XmlElement> root_;
  std::multimap<std::string, const XmlElement*, std::less<>> by_id_;
};

}  // namespace tandem
