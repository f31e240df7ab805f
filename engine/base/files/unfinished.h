#pragma once

#include <filesystem>
#include <string>

namespace tandem {

/// A file or a folder that is written beside its place until it is whole is called
/// PLACE.unfinished-PID-N. The program that writes it holds a lock on it. So another program can
/// tell it from the remainder of a killed program.

/// Returns such a name, of this process and not given before.
std::filesystem::path UnfinishedName(const std::filesystem::path& place);

/// Locks the file or folder that was made by that name, for as long as the descriptor is open.
/// Returns whether it still exists: another program may have taken it for a remainder before.
bool HoldUnfinished(int descriptor);

/// Removes remainders of ended programs of this user beside `place`. Leaves files whose owner it
/// cannot determine, as on a disk without locks.
void RemoveRemainders(const std::filesystem::path& place);

}  // namespace tandem
