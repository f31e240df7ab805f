#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/device/tandem_device.h"
#include "engine/base/result.h"

namespace tandem {

/// Loads drivers from shared libraries. A library stays loaded as long as the process, since the
/// vendors' libraries that it uses have threads and state of their own.
class DriverLibrary {
 public:
  /// Loads a file and checks what it exports, without calling a function of it. Errors say in a
  /// line what is wrong with the file.
  static Result<const TandemDriver*> Load(const std::filesystem::path& file);
};

/// Returns the folders of drivers, in the order of search: those of TANDEM_DEVICES (separated by
/// colons), then `lib/tandem/devices` beside the folder of this program.
std::vector<std::filesystem::path> DriverFolders();

/// A driver found in a folder.
struct DriverFile {
  std::string name;
  std::filesystem::path file;
  std::string refused;  // why it is not loaded: another user may have written it; empty: it is
};
/// Returns the drivers of all folders by name. A driver of TANDEM_DEVICES is refused where
/// WhyNotTrusted() says why: loading a library runs its code. Of two with the same name, the one in
/// the earlier folder counts.
std::vector<DriverFile> FindDrivers();

}  // namespace tandem
