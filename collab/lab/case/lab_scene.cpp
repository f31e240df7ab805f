#include "collab/lab/case/lab_scene.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace tandem {

namespace {

constexpr std::array<std::string_view, 5> kOwn{"free", "wall", "slot", "ball", "off_centre"};

Result<std::uint32_t> SharedBodyOf(const Scene& scene, const std::string& name) {
  const auto wrong = [&scene](const std::string& what) {
    return Error{scene.file.string() + ": " + what};
  };
  if (!name.empty()) {
    const int body = scene.BodyNamed(name);
    if (body < 0) return wrong("there is no body '" + name + "'");
    if (!scene.bodies[static_cast<std::size_t>(body)].shared) {
      return wrong("'" + name + "' is not shared: several users cannot hold it");
    }
    return static_cast<std::uint32_t>(body);
  }
  const auto is_shared = [](const SceneBody& body) {
    return body.shared;
  };
  const auto first = std::find_if(scene.bodies.begin(), scene.bodies.end(), is_shared);
  if (first == scene.bodies.end()) return wrong("it has no shared body");
  if (std::find_if(first + 1, scene.bodies.end(), is_shared) != scene.bodies.end()) {
    return wrong("it has several shared bodies: the case must name one as its body");
  }
  return static_cast<std::uint32_t>(first - scene.bodies.begin());
}

}  // namespace

Result<LabScene> LoadLabScene(const LabCase& test, const std::filesystem::path& folder) {
  const bool own = std::find(kOwn.begin(), kOwn.end(), test.scene) != kOwn.end();
  const bool off_centre = test.scene == "off_centre";
  const std::filesystem::path file = own ? folder / ((off_centre ? "free" : test.scene) + ".json")
                                         : std::filesystem::path(test.scene);
  const Result<Scene> scene = LoadScene(file);
  if (!scene) return scene.error();
  const Result<std::uint32_t> object = SharedBodyOf(*scene, test.body);
  if (!object) return object.error();
  const Result<std::shared_ptr<const WorldModel>> model = LoadWorld(*scene);
  if (!model) return model.error();
  return LabScene{*model, *object};
}

}  // namespace tandem
