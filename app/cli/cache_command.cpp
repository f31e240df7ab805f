#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/program_cache.h"
#include "app/connection/scene_search.h"
#include "collab/transfer/scene_store.h"
#include "engine/base/files/regular_file.h"
#include "engine/base/text/json_text.h"
#include "engine/scene/scene.h"

namespace tandem {

namespace {

double SecondsSince(std::filesystem::file_time_type time) {
  return std::chrono::duration<double>(std::filesystem::file_time_type::clock::now() - time)
      .count();
}

std::string Megabytes(std::uint64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f MB", 1e-6 * static_cast<double>(bytes));
  return text;
}

/// Returns the name of a fetched scene, from its file; empty: the file cannot be read.
std::string NameOf(const FetchedScene& scene) {
  if (!scene.whole) return {};
  const Result<Scene> loaded = LoadScene(scene.folder / SceneStore::kSceneFile);
  return loaded ? PlainLine(loaded->name) : std::string();
}

/// Shows the scenes that were fetched from sessions. Returns them as JSON.
nlohmann::ordered_json ListScenes(bool as_json) {
  nlohmann::ordered_json scenes = nlohmann::ordered_json::array();
  const std::optional<SceneStore> store = FetchedScenes({});
  if (!store) return scenes;
  for (const FetchedScene& scene : store->Scenes()) {
    const std::string name = NameOf(scene);
    scenes.push_back({{"folder", scene.folder.string()},
                      {"name", name},
                      {"bytes", scene.bytes},
                      {"unused_s", SecondsSince(scene.used)},
                      {"whole", scene.whole}});
    if (as_json) continue;
    PrintLine("%10s  last used %.0f h ago  %s in %s", Megabytes(scene.bytes).c_str(),
              SecondsSince(scene.used) / 3600,
              (scene.whole ? "scene " + name : std::string("a part of a scene")).c_str(),
              scene.folder.c_str());
  }
  return scenes;
}

int ListCache(const VoxelCache& cache, bool as_json) {
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  std::uint64_t sum = 0;
  for (const CachedFile& file : cache.Files()) {
    sum += file.bytes;
    files.push_back({{"file", file.file.string()},
                     {"bytes", file.bytes},
                     {"unused_s", SecondsSince(file.used)}});
    if (as_json) continue;
    PrintLine("%10s  last used %.0f h ago  %s", Megabytes(file.bytes).c_str(),
              SecondsSince(file.used) / 3600, file.file.filename().c_str());
  }
  if (as_json) {
    const nlohmann::ordered_json out{{"folder", cache.folder().string()},
                                     {"bytes", sum},
                                     {"most_bytes", cache.most_bytes()},
                                     {"files", files},
                                     {"fetched_scenes", ListScenes(true)}};
    PrintText(JsonText(out, 2));
  } else {
    ListScenes(false);
    PrintLine("%s in %s, at most %s, in %s", Megabytes(sum).c_str(),
              WithPlural(files.size(), "file").c_str(), Megabytes(cache.most_bytes()).c_str(),
              cache.folder().c_str());
  }
  return kExitOk;
}

int VerifyCache(const VoxelCache& cache, bool as_json) {
  nlohmann::ordered_json faults = nlohmann::ordered_json::array();
  const std::vector<CachedFile> files = cache.Files();
  for (const CachedFile& file : files) {
    const std::optional<Error> fault = VoxelCache::FaultOf(file.file);
    if (!fault) continue;
    faults.push_back({{"file", file.file.string()}, {"fault", fault->what}});
    if (!as_json) Say(fault->what);
  }
  if (as_json) {
    const nlohmann::ordered_json out{
        {"folder", cache.folder().string()}, {"files", files.size()}, {"faults", faults}};
    PrintText(JsonText(out, 2));
  } else {
    PrintLine("%s, %zu of them damaged or of another version%s",
              WithPlural(files.size(), "file").c_str(), faults.size(),
              faults.empty() ? "" : "; programs make them again when they need them");
  }
  return faults.empty() ? kExitOk : kExitFailed;
}

int ClearCache(const VoxelCache& cache, bool as_json) {
  const std::size_t count = cache.Clear();
  const std::optional<SceneStore> store = FetchedScenes({});
  const std::size_t scenes = store ? store->Clear() : 0;
  if (as_json) {
    const nlohmann::ordered_json out{{"folder", cache.folder().string()},
                                     {"removed", count},
                                     {"fetched_scenes_removed", scenes}};
    PrintText(JsonText(out, 2));
  } else {
    PrintLine("%s%s removed from %s", WithPlural(count, "file").c_str(),
              scenes > 0 ? (" and " + WithPlural(scenes, "fetched scene")).c_str() : "",
              cache.folder().c_str());
  }
  return kExitOk;
}

}  // namespace

void AddCacheCommand(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "cache",
      "Show, check or empty the cache of voxelized meshes and of scenes fetched from sessions");
  command->require_subcommand(1);
  const auto as_json = std::make_shared<bool>(false);
  const auto add = [&](const std::string& name, const std::string& what,
                       int (*run)(const VoxelCache&, bool)) {
    CLI::App* part = command->add_subcommand(name, what);
    part->add_flag("--json", *as_json, "print one JSON object");
    part->callback([as_json, run, &exit_code] {
      const VoxelCache* cache = ProgramCache();
      exit_code =
          cache != nullptr
              ? run(*cache, *as_json)
              : Fail(kExitFile, "there is no cache: TANDEM_CACHE is empty, or HOME is not set");
    });
  };
  add("list", "List its files and fetched scenes, the last used first", ListCache);
  add("verify", "Read all files and report damaged ones", VerifyCache);
  add("clear", "Remove all files and fetched scenes", ClearCache);
}

}  // namespace tandem
