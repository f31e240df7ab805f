#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <dlfcn.h>
#include <unistd.h>

#include "app/device/tandem_device.h"
#include "engine/base/files/trusted_file.h"

/// Helpers that drivers share: options, texts in arrays, and libraries loaded at run time.
namespace tandem::driver {

/// Copies a text into an array, and cuts it where it is too long.
template <std::size_t kRoom>
void Put(char (&room)[kRoom], std::string_view text) {
  const std::size_t count = std::min(text.size(), kRoom - 1);
  std::memcpy(room, text.data(), count);
  room[count] = '\0';
}
inline std::int32_t Put(char* room, std::uint32_t size, std::string_view text) {
  if (text.empty() || size == 0) return TANDEM_FAILED;
  const std::size_t count = std::min<std::size_t>(text.size(), size - 1);
  std::memcpy(room, text.data(), count);
  room[count] = '\0';
  return TANDEM_OK;
}

/// The options of a driver, KEY=VALUE separated by commas. A driver takes the keys that it knows.
/// Then Fault() names the first invalid or unknown option in a line; empty: none.
class Options {
 public:
  explicit Options(std::string_view text) {
    while (!text.empty()) {
      const std::string_view word = text.substr(0, text.find(','));
      text.remove_prefix(std::min(text.size(), word.size() + 1));
      if (word.empty()) continue;
      const std::size_t equals = word.find('=');
      if (equals == std::string_view::npos) {
        Blame("'" + std::string(word) + "': expected KEY=VALUE");
        continue;
      }
      values_[std::string(word.substr(0, equals))] = std::string(word.substr(equals + 1));
    }
  }
  std::string Text(const std::string& key, std::string fallback = {}) {
    const auto value = values_.find(key);
    if (value == values_.end()) return fallback;
    std::string text = value->second;
    values_.erase(value);
    return text;
  }
  /// Returns a number within the limits; without limits any number.
  double Number(const std::string& key, double fallback, double least = -kAny, double most = kAny) {
    const std::string text = Text(key);
    if (text.empty()) return fallback;
    double number = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
    const bool is_any = least == -kAny && most == kAny;
    const bool is_number = fault == std::errc{} && end == text.data() + text.size();
    if (is_number && (is_any || (number >= least && number <= most))) return number;
    char range[80] = "";
    if (!is_any) std::snprintf(range, sizeof range, " from %g to %g", least, most);
    Blame(key + ": expected a number" + range + ", got '" + text + "'");
    return fallback;
  }
  bool Flag(const std::string& key, bool fallback) {
    const std::string text = Text(key);
    if (text.empty()) return fallback;
    if (text != "yes" && text != "no") Blame(key + ": expected yes or no, got '" + text + "'");
    return text == "yes";
  }
  /// Returns the first fault, or names an option that was given and not taken.
  std::string Fault() const {
    if (!fault_.empty() || values_.empty()) return fault_;
    return "'" + values_.begin()->first + "' is not an option of this driver";
  }

 private:
  static constexpr double kAny = std::numeric_limits<double>::infinity();
  void Blame(const std::string& why) {
    if (fault_.empty()) fault_ = why;
  }
  std::map<std::string, std::string> values_;
  std::string fault_;
};

/// A vendor's library, loaded at run time. It is never unloaded, since it may have threads and
/// state of its own.
class VendorLibrary {
 public:
  /// Loads the first of these files that exists. `global`: other libraries can use its symbols.
  bool Load(const std::vector<std::string>& files, bool global = false) {
    bool is_there = false;
    for (const std::string& file : files) {
      if (file.empty()) continue;
      if (const std::string fault = Distrust(file); !fault.empty()) {
        why_ = fault;
        is_there = true;
        continue;
      }
      handle_ = dlopen(file.c_str(), RTLD_NOW | (global ? RTLD_GLOBAL : RTLD_LOCAL));
      if (handle_ != nullptr) return true;
      const char* why = dlerror();
      if (why == nullptr) continue;
      // a file that exists and lacks another library explains more than a file that does not exist
      const bool lacks_another = std::strncmp(why, file.c_str(), file.size()) != 0;
      if (why_.empty() || (lacks_another && !is_there)) why_ = why;
      is_there = is_there || lacks_another;
    }
    return false;
  }
  /// Takes a function; missing() names the first that the library lacks.
  template <typename Function>
  void Take(Function*& function, const char* name) {
    function = reinterpret_cast<Function*>(dlsym(handle_, name));
    if (function == nullptr && missing_.empty()) missing_ = name;
  }
  bool loaded() const { return handle_ != nullptr; }
  /// Returns the loader's message for the first file that exists, else for the first file.
  const std::string& why() const { return why_; }
  /// Returns the first function that the library lacks; empty: none.
  const std::string& missing() const { return missing_; }

 private:
  /// Returns why a file must not be loaded; empty: it may, or is not there. The loader finds names
  /// without a folder in the system's folders.
  static std::string Distrust(const std::string& file) {
    const bool named = file.find('/') != std::string::npos && access(file.c_str(), F_OK) == 0;
    return named ? WhyNotTrusted(file) : "";
  }

  void* handle_ = nullptr;
  std::string why_;
  std::string missing_;
};

}  // namespace tandem::driver
