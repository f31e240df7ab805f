#pragma once

#include <QString>

namespace tandem {

/// Returns a line of a controller, or of another program, in words for a user of the window. A line
/// for a terminal names options and commands. The fields of the window stand in place of options,
/// and remarks on other options or on commands are left out.
QString WordsForWindow(const QString& line);

}  // namespace tandem
