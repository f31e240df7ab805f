#include "app/peer/current_scene.h"

#include <nlohmann/json.hpp>

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

}  // namespace

Result<bool> WriteCurrentScene(const Scene& scene, const std::vector<Pose>& displaced,
                               const std::optional<AddedBody>& added, const fs::path& file,
                               bool overwrite) {
  std::error_code not_there;
  if (!overwrite && fs::exists(file, not_there)) {
    return Error{file.string() + " exists already and is not overwritten: choose another name"};
  }
  constexpr std::uintmax_t kLargest = 64U << 20U;
  const Result<std::string> text = ReadWholeFile(scene.file, kLargest);
  if (!text) return text.error();
  SceneJson json = SceneJson::parse(*text, nullptr, false, true);
  if (json.is_discarded() || !json.contains("bodies") ||
      json["bodies"].size() != scene.bodies.size()) {
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
  const auto failed = WriteWholeFile(file, JsonText(json, 2) + '\n');
  if (failed) return *failed;
  return true;
}

}  // namespace tandem
