#include "engine/geometry/formats/collada/xml_tree.h"

#include <algorithm>

#include "engine/geometry/formats/xml_scanner.h"

namespace tandem {

namespace {

constexpr std::size_t kDeepestElements = 256;

}  // namespace

std::string XmlElement::Attribute(std::string_view wanted) const {
  for (const auto& [key, value] : attributes) {
    if (key == wanted) return value;
  }
  return {};
}

bool XmlElement::HasAttribute(std::string_view wanted) const {
  return std::ranges::any_of(attributes, [&](const auto& attribute) {
    return attribute.first == wanted;
  });
}

const XmlElement* XmlElement::Child(std::string_view wanted) const {
  for (const auto& child : children) {
    if (child->name == wanted) return child.get();
  }
  return nullptr;
}

std::vector<const XmlElement*> XmlElement::Children(std::string_view wanted) const {
  std::vector<const XmlElement*> found;
  for (const auto& child : children) {
    if (child->name == wanted) found.push_back(child.get());
  }
  return found;
}

std::vector<std::string_view> XmlElement::Words() const {
  constexpr std::string_view kSpace = " \t\r\n";
  std::vector<std::string_view> words;
  for (std::string_view text : texts) {
    while (true) {
      text.remove_prefix(std::min(text.find_first_not_of(kSpace), text.size()));
      if (text.empty()) break;
      const std::string_view word = text.substr(0, text.find_first_of(kSpace));
      words.push_back(word);
      text.remove_prefix(word.size());
    }
  }
  return words;
}

Result<XmlTree> XmlTree::Parse(std::string_view text) {
  XmlTree tree;
  std::vector<XmlElement*> open;
  XmlScanner xml(text);
  for (auto piece = xml.Next(); piece != XmlScanner::Piece::kEnd; piece = xml.Next()) {
    if (piece == XmlScanner::Piece::kFault)
      return Error{"is not whole: it is damaged or cut short"};
    if (piece == XmlScanner::Piece::kText && !open.empty())
      open.back()->texts.push_back(xml.text());
    if (piece == XmlScanner::Piece::kClose) {
      if (open.empty() || open.back()->name != xml.name()) {
        return Error{"closes an element that is not open: it is damaged"};
      }
      open.pop_back();
    }
    if (piece != XmlScanner::Piece::kOpen) continue;
    auto element = std::make_unique<XmlElement>();
    element->name = xml.name();
    element->attributes = xml.Attributes();
    XmlElement* added = element.get();
    if (const std::string id = added->Attribute("id"); !id.empty()) tree.by_id_.emplace(id, added);
    if (!open.empty()) {
      open.back()->children.push_back(std::move(element));
    } else if (tree.root_ == nullptr) {
      tree.root_ = std::move(element);
    } else {
      return Error{"has several first elements: it is damaged"};
    }
    if (!xml.empty()) open.push_back(added);
    if (open.size() > kDeepestElements) return Error{"has elements nested too deep"};
  }
  if (tree.root_ == nullptr || !open.empty()) {
    return Error{"is not whole: it is damaged or cut short"};
  }
  return tree;
}

std::vector<const XmlElement*> XmlTree::ById(std::string_view id) const {
  std::vector<const XmlElement*> elements;
  const auto [begin, end] = by_id_.equal_range(id);
  for (auto at = begin; at != end; ++at) elements.push_back(at->second);
  return elements;
}

}  // namespace tandem
