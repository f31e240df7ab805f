#include "collab/transfer/scene_files.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "collab/transfer/file_messages.h"
#include "engine/base/text/json_reader.h"
#include "engine/base/text/json_text.h"
#include "engine/geometry/formats/gltf_buffers.h"
#include "engine/scene/scene_hash.h"

namespace tandem {

namespace {

namespace fs = std::filesystem;
using SceneJson = nlohmann::ordered_json;

constexpr std::string_view kFile = "file:";

std::string KindOf(const fs::path& file) {
  std::string kind = file.extension().string();
  std::ranges::transform(kind, kind.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return kind;
}

Error Unsound(const std::string& why) {
  return Error{"the scene file that was sent is refused: " + why};
}

/// Parses a scene file of at most kMostSceneBytes.
Result<SceneJson> ParseScene(const std::string& text) {
  if (text.size() > SceneList::kMostSceneBytes) return Unsound("it is larger than 4 MB");
  // brackets and values are counted first, so that the parser cannot be overloaded
  const Result<JsonFile> sound = JsonFile::Parse(text, "the scene file that was sent");
  if (!sound) return sound.error();
  SceneJson json = SceneJson::parse(text, nullptr, false);
  const bool is_scene = json.is_object() && json.contains("bodies") && json["bodies"].is_array();
  if (!is_scene) return Unsound("it is no scene");
  for (const SceneJson& body : json["bodies"]) {
    if (!body.is_object()) return Unsound("it is no scene");
  }
  return json;
}

/// Returns the number in "file:N"; nullopt if the text is not exactly that.
std::optional<std::size_t> FileNumber(const SceneJson& mesh) {
  if (!mesh.is_string()) return std::nullopt;
  const auto& text = mesh.get_ref<const std::string&>();
  std::size_t number = 0;
  if (!text.starts_with(kFile)) return std::nullopt;
  const char* const end = text.data() + text.size();
  const auto [rest, fault] = std::from_chars(text.data() + kFile.size(), end, number);
  if (fault != std::errc() || rest != end) return std::nullopt;
  return text == std::string(kFile) + std::to_string(number) ? std::optional(number) : std::nullopt;
}

/// Adds a file of `bytes` bytes to the list; `read(at, piece)` fills a piece.
template <typename Read>
std::optional<Error> AddFile(SceneList& list, const std::string& kind, std::uint64_t bytes,
                             const std::atomic<bool>& stop, const Read& read) {
  ListedFile file{.kind = kind, .bytes = bytes, .digest = {}, .pieces = {}};
  RunningSha256 whole;
  std::vector<char> piece;
  for (std::uint64_t at = 0; at < bytes; at += piece.size()) {
    if (stop.load(std::memory_order_relaxed)) return Error{"told to stop"};
    piece.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kPieceBytes, bytes - at)));
    if (!read(at, piece)) return Error{"a mesh file of the scene has changed"};
    whole.Add(piece);
    file.pieces.push_back(Sha256Of(piece));
  }
  file.digest = whole.Value();
  list.files.push_back(std::move(file));
  return std::nullopt;
}

}  // namespace

Result<std::string> TravellingScene(const std::string& scene_file,
                                    const std::vector<std::size_t>& file_of_body) {
  Result<SceneJson> json = ParseScene(scene_file);
  if (!json) return json.error();
  SceneJson& bodies = (*json)["bodies"];
  if (bodies.size() != file_of_body.size()) return Unsound("it is not any more what was loaded");
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    bodies[i]["mesh"] = std::string(kFile) + std::to_string(file_of_body[i]);
  }
  json->erase("hands");
  return JsonText(*json, 1) + '\n';
}

Result<std::string> ArrivedScene(const std::string& travelled,
                                 const std::vector<std::string>& names) {
  Result<SceneJson> json = ParseScene(travelled);
  if (!json) return json.error();
  if (json->contains("hands")) return Unsound("it names files of hands");
  for (SceneJson& body : (*json)["bodies"]) {
    const auto number = body.contains("mesh") ? FileNumber(body["mesh"]) : std::nullopt;
    if (!number || *number == 0 || *number >= names.size()) {
      return Unsound("a mesh that is none of its files");
    }
    body["mesh"] = names[*number];
  }
  return JsonText(*json, 1) + '\n';
}

std::string WhyNotToTravel(const Scene& scene) {
  for (const SceneBody& body : scene.bodies) {
    const std::string kind = KindOf(body.mesh);
    if (kind == ".json" || !IsSceneFileKind(kind)) {
      return PlainLine(body.mesh.string()) + ": files of this kind are not handed to joiners";
    }
    const Result<std::vector<fs::path>> buffers = GltfBuffers(body.mesh);
    if (!buffers) return buffers.error().what;
    if (!buffers->empty()) {
      return PlainLine(body.mesh.string()) +
             ": its numbers are in other files, so that it is not handed to joiners: save it as "
             ".glb";
    }
  }
  return {};
}

Result<SceneFiles> SceneFiles::Open(const fs::path& scene_file, const Sha256& content,
                                    const std::atomic<bool>& stop) {
  const Result<Scene> loaded = LoadScene(scene_file);
  if (!loaded) return loaded.error();
  const Scene& scene = *loaded;
  if (const std::string why = WhyNotToTravel(scene); !why.empty()) return Error{why};
  SceneFiles files;
  files.list_.files.emplace_back();  // place of the scene file
  std::map<fs::path, std::size_t> of_path;
  std::map<std::pair<Sha256, std::string>, std::size_t> of_content;
  std::vector<std::size_t> file_of_body;
  for (const SceneBody& body : scene.bodies) {
    if (const auto known = of_path.find(body.mesh); known != of_path.end()) {
      file_of_body.push_back(known->second);
      continue;
    }
    Result<RegularFile> mesh = RegularFile::Open(body.mesh);
    if (!mesh) return mesh.error();
    const auto failed = AddFile(files.list_, KindOf(body.mesh), mesh->size(), stop,
                                [&mesh](std::uint64_t at, std::vector<char>& piece) {
                                  return mesh->Read(at, piece) == piece.size();
                                });
    if (failed) return *failed;
    const ListedFile& listed = files.list_.files.back();
    const auto [same, is_new] =
        of_content.try_emplace({listed.digest, listed.kind}, files.list_.files.size() - 1);
    if (is_new) {
      files.meshes_.push_back(*std::move(mesh));
    } else {
      files.list_.files.pop_back();
    }
    of_path[body.mesh] = same->second;
    file_of_body.push_back(same->second);
  }
  if (files.list_.files.size() > SceneList::kMostFiles) {
    return Error{scene.file.string() + " has too many files to be handed to joiners"};
  }
  const Result<std::string> text = ReadWholeFile(scene.file, SceneList::kMostSceneBytes);
  if (!text) return text.error();
  Result<std::string> travelling = TravellingScene(*text, file_of_body);
  if (!travelling) return travelling.error();
  files.scene_ = *std::move(travelling);
  SceneList first;
  const auto failed =
      AddFile(first, ".json", files.scene_.size(), stop,
              [&files](std::uint64_t at, std::vector<char>& piece) {
                files.scene_.copy(piece.data(), piece.size(), static_cast<std::size_t>(at));
                return true;
              });
  if (failed) return *failed;
  files.list_.files.front() = std::move(first.files.front());
  // last: the hashed files are the opened ones, unless a program writes into them now
  const Result<SceneHash> hash = HashScene(scene);
  if (!hash) return hash.error();
  if (hash->digest != content) {
    return Error{PlainLine(scene_file.string()) + " or its mesh files have changed"};
  }
  return files;
}

bool SceneFiles::Read(std::uint32_t number, std::vector<char>& piece) const {
  const PiecePlace place = PlaceOf(list_, number);
  piece.resize(place.bytes);
  if (place.file == 0) {
    scene_.copy(piece.data(), piece.size(), static_cast<std::size_t>(place.at));
    return true;
  }
  return meshes_[place.file - 1].Read(place.at, piece) == piece.size();
}

}  // namespace tandem
