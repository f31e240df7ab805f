#include "engine/base/text/csv_text.h"

#include <charconv>
#include <system_error>

namespace tandem {
namespace {

bool IsNumber(std::string_view text) {
  if (text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end;
}

}  // namespace

std::string CsvText(std::string_view text) {
  std::string cell;
  // spreadsheets skip spaces before a formula, and some take the wide forms of its signs too
  const std::size_t first = text.find_first_not_of(' ');
  const std::string_view rest = first == std::string_view::npos ? "" : text.substr(first);
  constexpr std::string_view kSigns = "=+-@\t\r\n";
  const bool wide = rest.starts_with("\uFF1D") || rest.starts_with("\uFF0B") ||
                    rest.starts_with("\uFF0D") || rest.starts_with("\uFF20");
  const bool sign = !rest.empty() && kSigns.find(rest.front()) != std::string_view::npos;
  if (wide || (sign && !IsNumber(rest))) cell += '\'';
  cell += text;
  if (cell.find_first_of(",\"\r\n") == std::string::npos) return cell;
  std::string quoted = "\"";
  for (const char c : cell) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

}  // namespace tandem
