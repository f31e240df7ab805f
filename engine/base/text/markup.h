#pragma once

#include <string>

namespace tandem {

/// Returns the text escaped for HTML and XML, also within attributes. Control characters, which XML
/// cannot hold, become blanks.
inline std::string EscapedMarkup(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default: {
        const auto byte = static_cast<unsigned char>(c);
        const bool control = byte < 0x20 && c != '\n' && c != '\t';
        out += control ? ' ' : c;
      }
    }
  }
  return out;
}

/// Returns an element with escaped text. `element` may have attributes:
/// MarkupElement("td class=\"n\"", "1") is <td class="n">1</td>.
inline std::string MarkupElement(const std::string& element, const std::string& text) {
  return "<" + element + ">" + EscapedMarkup(text) + "</" + element.substr(0, element.find(' ')) +
         ">";
}

}  // namespace tandem
