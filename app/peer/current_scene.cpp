#include "app/peer/current_scene.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>

#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/base/files/regular_file.h"
#include "engine/base/files/whole_file.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

namespace fs = std::filesystem;
using SceneJson = nlohmann::ordered_json;

SceneJson PoseJson(const Pose& X) {
  return {{"p_W", {X.p.x(), X.p.y(), X.p.z()}}, {"q_xyzw", {X.q.x(), X.q.y(), X.q.z(), X.q.w()}}};
}

/// Returns the absolute path of a file as a scene names it. Notes in `unnamed` the first file that
/// no scene can name, because JSON holds UTF-8 alone.
std::string NameOf(const fs::path& file, std::optional<Error>& unnamed) {
  std::error_code not_there;
  const fs::path absolute = fs::absolute(file, not_there);
  if (!unnamed && !IsPlainText(absolute.native())) {
    unnamed = Error{PlainLine(absolute.native()) +
                    ": a scene cannot name this file, because its path is not UTF-8: rename the "
                    "folder or the file"};
  }
  return absolute.string();
}

constexpr std::uintmax_t kLargestScene = 64U << 20U;  // bytes

/// Tells whether each key of a scene's JSON is a word of letters, digits and '_', and each list has
/// no text of its own. Then every line of the file begins with a bracket, a number or such a key.
bool HasSoundKeys(const SceneJson& json) {
  for (const auto& [key, value] : json.items()) {
    const bool is_word = std::ranges::all_of(key, [](char c) {
      return c == '_' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    });
    if (!is_word || (json.is_array() && value.is_string())) return false;
    if (value.is_structured() && !HasSoundKeys(value)) return false;
  }
  return true;
}

/// Returns JSON in which no text has a character that a shell expands, or a control character: each
/// of these is written as its number (JSON's \uXXXX). Outside of texts JSON has none of them.
std::string ShellSafe(std::string_view json) {
  constexpr std::string_view kExpanded = "$`();<>&|!'";
  std::string safe;
  const auto escape = [&safe](unsigned code) {
    std::array<char, 8> text{};
    std::snprintf(text.data(), text.size(), "\\u%04x", code);
    safe += text.data();
  };
  for (std::size_t i = 0; i < json.size(); ++i) {
    const auto byte = static_cast<unsigned char>(json[i]);
    const auto next = static_cast<unsigned char>(i + 1 < json.size() ? json[i + 1] : 0);
    if (byte == 0xC2 && next < 0xA0) {  // a control character of two bytes
      escape(next);
      ++i;
    } else if (byte == 0x7F || kExpanded.find(json[i]) != std::string_view::npos) {
      escape(byte);
    } else {
      safe += json[i];
    }
  }
  return safe;
}

/// Returns the first link on the way to a folder that neither this user nor root has made; empty:
/// there is none.
fs::path AnothersLink(const fs::path& folder) {
  fs::path way;
  for (const fs::path& part : folder) {
    way /= part;
    struct stat facts {};
    if (lstat(way.c_str(), &facts) != 0 || !S_ISLNK(facts.st_mode)) continue;
    if (facts.st_uid != geteuid() && facts.st_uid != 0) return way;
  }
  return {};
}

/// Tells whether a folder is one of the system's.
bool IsOfTheSystem(const fs::path& folder) {
  const auto second = std::next(folder.begin());
  if (second == folder.end()) return true;
  const std::string first = second->string();
  return std::ranges::any_of(
      std::array{"bin", "boot", "dev", "etc", "lib", "lib64", "proc", "sbin", "sys", "usr"},
      [&first](const char* name) {
        return first == name;
      });
}

}  // namespace

std::optional<Error> WhyNoPlaceForScene(const fs::path& file, const fs::path& scene) {
  const std::string shown = PlainLine(file.native());
  if (!file.is_absolute()) return Error{"'" + shown + "': expected an absolute path"};
  if (!IsPlainText(file.native())) {
    return Error{shown + ": the name has control characters or is not UTF-8: choose another name"};
  }
  if (file.extension() != ".json" || file.filename().native().starts_with('.')) {
    return Error{shown + ": a scene is saved under a name that ends in .json and does not begin " +
                 "with '.': choose another name"};
  }
  std::error_code unknown;
  const fs::path folder = fs::canonical(file.parent_path(), unknown);
  if (unknown || !fs::is_directory(folder, unknown)) {
    return Error{PlainLine(file.parent_path().native()) + ": there is no such folder"};
  }
  if (folder == fs::canonical(scene.parent_path(), unknown)) return std::nullopt;
  if (const fs::path link = AnothersLink(file.parent_path()); !link.empty()) {
    return Error{PlainLine(link.native()) + ": another user has made this link: name the folder " +
                 "that it leads to"};
  }
  const bool is_hidden = std::ranges::any_of(folder, [](const fs::path& part) {
    return part.native().starts_with('.');
  });
  if (is_hidden || IsOfTheSystem(folder)) {
    return Error{PlainLine(folder.native()) + ": a scene is not saved in a hidden folder or a " +
                 "folder of the system: choose another folder"};
  }
  return std::nullopt;
}

std::string ReasonWithoutContent(const fs::path& file, const std::string& why) {
  const Result<std::string> text = ReadWholeFile(file, kLargestScene);
  if (!text) return why;  // it has not been read then either
  const SceneJson json = SceneJson::parse(*text, nullptr, false, true);
  if (json.is_object() && json.contains("bodies") && json.contains("voxel_m")) return why;
  return PlainLine(file.native()) +
         ": is no scene, which is a JSON object with \"voxel_m\" and \"bodies\": name another file";
}

std::string WithoutQuotedText(std::string_view words) {
  std::string plain;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const char c = words[i];
    const bool opens = (c == '\'' || c == '"') && (i == 0 || words[i - 1] == ' ' ||
                                                   words[i - 1] == '(' || words[i - 1] == ':');
    plain += c;
    if (!opens) continue;
    // up to the last such mark, since a quoted text may have the mark in it
    const std::size_t end = words.rfind(c);
    if (end == i) return plain + "...";
    plain += "...";
    i = end - 1;
  }
  return plain;
}

Result<bool> WriteCurrentScene(const Scene& scene, const std::vector<Pose>& displaced,
                               const std::optional<AddedBody>& added, const fs::path& file,
                               bool overwrite) {
  std::error_code not_there;
  if (!overwrite && fs::exists(file, not_there)) {
    return Error{file.string() + " exists already and is not overwritten: choose another name"};
  }
  const Result<std::string> text = ReadWholeFile(scene.file, kLargestScene);
  if (!text) return text.error();
  SceneJson json = SceneJson::parse(*text, nullptr, false, true);
  if (json.is_discarded() || !json.contains("bodies") ||
      json["bodies"].size() != scene.bodies.size() || !HasSoundKeys(json)) {
    return Error{scene.file.string() + " has changed since it was loaded"};
  }
  std::optional<Error> unnamed;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    SceneJson& body = json["bodies"][i];
    body["mesh"] = NameOf(scene.bodies[i].mesh, unnamed);
    const Pose X_WM = displaced[i] * scene.bodies[i].X_WM;
    body["pose"] = PoseJson({X_WM.q.normalized(), X_WM.p});
  }
  for (std::size_t i = 0; i < scene.hands.size(); ++i) {
    json["hands"][i]["file"] = NameOf(scene.hands[i].file, unnamed);
  }
  if (added) {
    SceneJson body{{"name", added->name.empty() ? added->mesh.stem().string() : added->name},
                   {"mesh", NameOf(added->mesh, unnamed)}};
    if (added->fixed) {
      body["fixed"] = true;
    } else {
      body["mass_kg"] = added->mass_kg;
      if (added->shared) body["sharing"] = "shared";
    }
    json["bodies"].push_back(body);
  }
  if (unnamed) return *unnamed;
  const bool is_beside = fs::canonical(file.parent_path(), not_there) ==
                         fs::canonical(scene.file.parent_path(), not_there);
  const auto failed =
      WriteWholeFile(file, ShellSafe(JsonText(json, 2)) + '\n', is_beside ? 0666 : 0600);
  if (failed) return *failed;
  return true;
}

}  // namespace tandem
