#include "engine/geometry/formats/xml_scanner.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace tandem {

namespace {

constexpr std::string_view kSpace = " \t\r\n";

std::string_view LocalName(std::string_view name) {
  const std::size_t colon = name.rfind(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

std::string WithEntities(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, char>, 5> kEntities{
      {{"amp", '&'}, {"lt", '<'}, {"gt", '>'}, {"quot", '"'}, {"apos", '\''}}};
  std::string plain;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const std::size_t end = text[at] == '&' ? text.find(';', at) : std::string_view::npos;
    const std::string_view word =
        end == std::string_view::npos ? std::string_view() : text.substr(at + 1, end - at - 1);
    const auto* const known = std::ranges::find(kEntities, word, [](const auto& entity) {
      return entity.first;
    });
    unsigned code = 0;
    if (known != kEntities.end()) {
      plain += known->second;
      at = end;
    } else if (word.starts_with("#") && word.size() < 8 &&
               std::from_chars(word.data() + 1, word.data() + word.size(), code).ec ==
                   std::errc() &&
               code < 0x80) {
      plain += static_cast<char>(code);
      at = end;
    } else {
      plain += text[at];
    }
  }
  return plain;
}

}  // namespace

XmlScanner::XmlScanner(std::string_view text) : rest_(text) {
  if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
}

bool XmlScanner::SkipUpTo(std::string_view words) {
  const std::size_t at = rest_.find(words);
  if (at == std::string_view::npos) return false;
  rest_.remove_prefix(at + words.size());
  return true;
}

XmlScanner::Piece XmlScanner::Next() {
  while (!rest_.empty()) {
    if (rest_.front() != '<') {
      text_ = rest_.substr(0, rest_.find('<'));
      rest_.remove_prefix(text_.size());
      return Piece::kText;
    }
    if (rest_.starts_with("<!--")) {
      if (!SkipUpTo("-->")) return Piece::kFault;
    } else if (rest_.starts_with("<![CDATA[")) {
      rest_.remove_prefix(9);
      text_ = rest_.substr(0, rest_.find("]]>"));
      if (!SkipUpTo("]]>")) return Piece::kFault;
      return Piece::kText;
    } else if (rest_.starts_with("<?")) {
      if (!SkipUpTo("?>")) return Piece::kFault;
    } else if (rest_.starts_with("<!DOCTYPE") && rest_.find('[') > rest_.find('>')) {
      SkipUpTo(">");  // it names a schema, and declares nothing
    } else if (rest_.starts_with("<!")) {
      return Piece::kFault;  // declarations, which models do not have
    } else {
      return ReadTag();
    }
  }
  return depth_ == 0 ? Piece::kEnd : Piece::kFault;
}

XmlScanner::Piece XmlScanner::ReadTag() {
  // a value in quotes may contain a bracket
  char quote = '\0';
  std::size_t end = 1;
  for (; end < rest_.size(); ++end) {
    const char c = rest_[end];
    if (quote != '\0') {
      if (c == quote) quote = '\0';
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      break;
    }
  }
  if (end == rest_.size()) return Piece::kFault;
  std::string_view tag = rest_.substr(1, end - 1);
  rest_.remove_prefix(end + 1);
  attributes_.clear();
  const bool closes = tag.starts_with('/');
  if (closes) tag.remove_prefix(1);
  empty_ = tag.ends_with('/');
  if (empty_) tag.remove_suffix(1);
  const std::string_view name = tag.substr(0, tag.find_first_of(kSpace));
  name_ = LocalName(name);
  prefix_ = name.size() > name_.size() ? name.substr(0, name.size() - name_.size() - 1)
                                       : std::string_view();
  if (name_.empty()) return Piece::kFault;
  if (closes) --depth_;
  if (closes) return depth_ < 0 ? Piece::kFault : Piece::kClose;
  if (!empty_) ++depth_;
  return ReadAttributes(tag.substr(name.size())) ? Piece::kOpen : Piece::kFault;
}

bool XmlScanner::ReadAttributes(std::string_view tag) {
  while (true) {
    const std::size_t begin = tag.find_first_not_of(kSpace);
    if (begin == std::string_view::npos) return true;
    tag.remove_prefix(begin);
    const std::size_t equals = tag.find('=');
    if (equals == std::string_view::npos) return false;
    std::string_view name = tag.substr(0, equals);
    name = name.substr(0, name.find_first_of(kSpace));
    tag.remove_prefix(equals + 1);
    const std::size_t open = tag.find_first_not_of(kSpace);
    if (open == std::string_view::npos || (tag[open] != '"' && tag[open] != '\'')) return false;
    const std::size_t close = tag.find(tag[open], open + 1);
    if (close == std::string_view::npos) return false;
    if (std::ranges::count(attributes_, name,
                           &std::pair<std::string_view, std::string_view>::first) > 0) {
      return false;
    }
    attributes_.emplace_back(name, tag.substr(open + 1, close - open - 1));
    tag.remove_prefix(close + 1);
  }
}

std::vector<std::pair<std::string, std::string>> XmlScanner::Attributes() const {
  std::vector<std::pair<std::string, std::string>> all;
  for (const auto& [name, value] : attributes_) {
    all.emplace_back(std::string(name), WithEntities(value));
  }
  return all;
}

std::optional<std::string> XmlScanner::Attribute(std::string_view name) const {
  if (std::optional<std::string> plain = AttributeAsWritten(name)) return plain;
  const auto found = std::ranges::find(attributes_, name, [](const auto& one) {
    return LocalName(one.first);
  });
  return found == attributes_.end() ? std::nullopt : std::optional(WithEntities(found->second));
}

std::optional<std::string> XmlScanner::AttributeAsWritten(std::string_view name) const {
  const auto found = std::ranges::find(attributes_, name, [](const auto& one) {
    return one.first;
  });
  return found == attributes_.end() ? std::nullopt : std::optional(WithEntities(found->second));
}

}  // namespace tandem
