#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/device/tandem_device.h"
#include "engine/base/result.h"

namespace tandem {

/// A driver in a shared library. The library stays loaded as long as the process, for vendors'
/// libraries that it brings along have threads and state of their own.
class DriverLibrary {
 public:
  /// Loads a file and checks what it exports. It calls no function of it. Errors: what is wrong
  /// with the file, in a line.
  static Result<const TandemDriver*> Load(const std::filesystem::path& file);
};

/// Where drivers are looked for, the first first: the folders of TANDEM_DEVICES (with colons
/// between), and `lib/tandem/devices` beside the folder of this program.
std::vector<std::filesystem::path> DriverFolders();

/// A driver that was found in a folder.
struct DriverFile {
  std::string name;
  std::filesystem::path file;
};
/// The drivers of all folders by name; of two with one name the one of the earlier folder.
std::vector<DriverFile> FindDrivers();

}  // namespace tandem
