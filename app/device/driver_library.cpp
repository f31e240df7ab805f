#include "app/device/driver_library.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <map>
#include <system_error>
#include <utility>

#include <dlfcn.h>

#include "app/common/program_folders.h"
#include "engine/base/files/trusted_file.h"

namespace tandem {
namespace {

/// Returns what is wrong with a driver's table; empty: it is complete.
std::string LackOf(const TandemDriver& driver) {
  if (driver.struct_size < offsetof(TandemDriver, extension)) return "its table is too short";
  if (driver.abi_major != TANDEM_DEVICE_ABI_MAJOR) {
    return "it is built for version " + std::to_string(driver.abi_major) +
           " of the interface, and this program has version " +
           std::to_string(TANDEM_DEVICE_ABI_MAJOR) + ": build it again";
  }
  const bool is_whole =
      driver.name != nullptr && driver.kind != nullptr && driver.options != nullptr &&
      driver.init != nullptr && driver.deinit != nullptr && driver.list != nullptr &&
      driver.open != nullptr && driver.close != nullptr && driver.capabilities != nullptr &&
      driver.start != nullptr && driver.read != nullptr && driver.write != nullptr &&
      driver.stop != nullptr && driver.last_error != nullptr;
  return is_whole ? "" : "its table lacks a function or a text";
}

bool IsDriverName(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
}

}  // namespace

Result<const TandemDriver*> DriverLibrary::Load(const std::filesystem::path& file) {
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* why = dlerror();
    return Error{file.string() +
                 ": cannot be loaded: " + (why != nullptr ? why : "no reason given")};
  }
  const auto* driver = static_cast<const TandemDriver*>(dlsym(library, "tandem_driver"));
  if (driver == nullptr)
    return Error{file.string() + ": is not a driver, because it exports no tandem_driver"};
  if (const std::string lack = LackOf(*driver); !lack.empty()) {
    return Error{file.string() + ": " + lack};
  }
  if (file.stem() != driver->name) {
    return Error{file.string() + ": its driver is called '" + driver->name +
                 "': rename the file to " + driver->name + ".so"};
  }
  return driver;
}

std::vector<std::filesystem::path> DriverFolders() {
  std::vector<std::filesystem::path> folders;
  if (const char* named =
          std::getenv("TANDEM_DEVICES")) {  // NOLINT(concurrency-mt-unsafe): at start
    std::string text = named;
    while (!text.empty()) {
      const std::string folder = text.substr(0, text.find(':'));
      text.erase(0, folder.size() + 1);
      if (!folder.empty()) folders.emplace_back(folder);
    }
  }
  folders.push_back(ProgramFolder().parent_path() / "lib" / "tandem" / "devices");
  return folders;
}

std::vector<DriverFile> FindDrivers() {
  std::map<std::string, DriverFile> found;
  const std::vector<std::filesystem::path> folders = DriverFolders();
  for (const std::filesystem::path& folder : folders) {
    // the last folder is as trustworthy as this program, which lies beside it
    const bool named = folder != folders.back();
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
      const std::filesystem::path& file = entry.path();
      const std::string name = file.stem();
      if (file.extension() != ".so" || !IsDriverName(name) || found.contains(name)) continue;
      found[name] = {name, file, named ? WhyNotTrusted(file) : ""};
    }
  }
  std::vector<DriverFile> drivers;
  for (auto& [name, driver] : found) drivers.push_back(std::move(driver));
  return drivers;
}

}  // namespace tandem
