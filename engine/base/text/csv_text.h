#pragma once

#include <string>
#include <string_view>

namespace tandem {

/// Returns a text as a cell of CSV, quoted as RFC 4180 asks.
///
/// A spreadsheet runs a cell that begins with =, +, -, @, a tab or a carriage return as a formula,
/// also within quotes. Such a text gets a ' in front, and is shown as it is. A number such as
/// -1.5e3 stays a number.
std::string CsvText(std::string_view text);

}  // namespace tandem
