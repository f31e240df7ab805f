#pragma once

#include <string>
#include <vector>

#include "engine/base/result.h"

namespace tandem {

/// Takes the words of a command line away from it: returns them, and blanks the secret part of each
/// invitation where the system shows it to all users of the machine (/proc/PID/cmdline). Called
/// first in main(). The words may be seen until then, so a secret is better given by GivenLine().
std::vector<std::string> TakeWords(int argc, char** argv);

/// Returns the line that a word of the command line stands for:
///
/// - `-`: the first line of stdin; a terminal is asked for it, and does not show it;
/// - `@FILE`: the first line of a file;
/// - any other word: the word itself.
Result<std::string> GivenLine(const std::string& word);

}  // namespace tandem
