#pragma once

#include <filesystem>
#include <string>

namespace tandem {

/// A file or a folder that is written beside its place until it is whole is called
/// PLACE.unfinished-PID-N. The program that writes it holds a lock on it, so that another one can
/// tell what is written from what is left of a program that was killed.

/// Returns such a name, of this process and not given before.
std::filesystem::path UnfinishedName(const std::filesystem::path& place);

/// Locks the file or folder that was made by that name, for as long as the descriptor is open.
/// Returns whether it is still there: another program may have taken it for a remainder before.
bool HoldUnfinished(int descriptor);

/// Removes what programs of this user that are no more have left beside `place`. Leaves what it
/// cannot judge, as on a disk without locks.
void RemoveRemainders(const std::filesystem::path& place);

}  // namespace tandem
