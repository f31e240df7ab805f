#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.h"
#include "engine/scene/scene.h"

namespace tandem {

/// A body that is added to a scene.
struct AddedBody {
  std::string name;  // name; empty: that of the file
  std::filesystem::path mesh;
  bool fixed = false;
  bool shared = true;
  double mass_kg = 1;
};

/// Returns why a host may not save a scene at this place; nothing: it may. A scene's file ends in
/// .json, and neither it nor its folders have names that begin with '.'. The folder is there, is no
/// system folder, and no link that another user has made leads to it. The folder of `scene`, the
/// file of the present scene, is always good.
std::optional<Error> WhyNoPlaceForScene(const std::filesystem::path& file,
                                        const std::filesystem::path& scene);

/// Returns what a host is told of a file that it has named and that is no sound scene. `why` may
/// quote the file, and is returned only where the file says that it is a scene.
std::string ReasonWithoutContent(const std::filesystem::path& file, const std::string& why);

/// Returns `words` with "..." in place of each quoted text, for words on a file that no host may
/// read this way.
std::string WithoutQuotedText(std::string_view words);

/// Writes the file of `scene` with each body where `displaced` has it. `displaced` has X_W for each
/// body of the scene: p_W at present = X_W * p_W of the file. All files get absolute names. Only
/// the folder of the scene gets a file that other users can read. No text of the file is one that a
/// shell expands. Errors: the scene cannot be read again, the file exists already without
/// `overwrite`, or it cannot be written.
Result<bool> WriteCurrentScene(const Scene& scene, const std::vector<Pose>& displaced,
                               const std::optional<AddedBody>& added,
                               const std::filesystem::path& file, bool overwrite);

}  // namespace tandem
