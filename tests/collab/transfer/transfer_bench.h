#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "collab/transfer/scene_fetch.h"
#include "collab/transfer/scene_files.h"
#include "collab/transfer/scene_server.h"
#include "collab/transfer/scene_store.h"
#include "engine/base/units.h"
#include "engine/scene/scene_hash.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {

/// Returns so many bytes, drawn by a seed, that no compression makes fewer.
inline std::string NoiseBytes(std::size_t bytes, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::string text(bytes, 0);
  std::ranges::generate(text, [&random] {
    return static_cast<char>(random());
  });
  return text;
}

/// Writes a scene whose meshes nobody reads: only bytes travel.
inline std::filesystem::path WriteScene(const ScratchFolder& folder, const std::string& name,
                                        const std::vector<std::string>& meshes) {
  std::filesystem::create_directories(folder.path() / name);
  std::string bodies;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const std::string mesh = "mesh " + std::to_string(i) + ".stl";
    folder.Write(name + "/" + mesh, meshes[i]);
    bodies += std::string(i == 0 ? "" : ",") + R"({"name": "body)" + std::to_string(i) +
              R"(", "mesh": ")" + mesh + R"(", "mass_kg": 1})";
  }
  return folder.Write(
      name + "/" + name + ".json",
      R"({"name": ")" + name + R"(", "voxel_m": 0.001, "bodies": [)" + bodies + "]}");
}

inline SceneHash HashesOf(const std::filesystem::path& scene) {
  const Result<Scene> loaded = LoadScene(scene);
  EXPECT_TRUE(loaded) << loaded.error().what;
  const Result<SceneHash> hash = HashScene(*loaded);
  EXPECT_TRUE(hash);
  return *hash;
}
inline std::uint64_t ContentOf(const std::filesystem::path& scene) {
  return HashesOf(scene).content;
}

/// Pieces in memory.
class MemoryStore : public PieceStore {
 public:
  bool Read(const PiecePlace& place, std::span<char> piece) override {
    const auto known = pieces.find({place.file, place.at});
    if (known == pieces.end() || known->second.size() != piece.size()) return false;
    std::ranges::copy(known->second, piece.begin());
    return true;
  }
  bool Write(const PiecePlace& place, std::span<const char> piece) override {
    if (pieces.size() == room) return false;
    pieces[{place.file, place.at}] = std::string(piece.begin(), piece.end());
    return true;
  }
  /// Returns the files, by their places in the list.
  std::map<std::size_t, std::string> Files() const {
    std::map<std::size_t, std::string> files;
    for (const auto& [place, bytes] : pieces) files[place.first] += bytes;
    return files;
  }
  std::map<std::pair<std::size_t, std::uint64_t>, std::string> pieces;
  std::size_t room = SIZE_MAX;
};

/// Servers, a fetching side and the way between them in virtual time.
class TransferBench {
 public:
  struct Server {
    std::unique_ptr<TransferEndpoint> party;
    std::int64_t next_ns = 0;
    bool here = true;
    /// Changes a piece that it sends; null: nothing is changed.
    std::function<void(FilePiece&)> spoil;
    std::uint64_t sent_bytes = 0;
  };

  static constexpr PeerId kJoiner = 99;

  explicit TransferBench(std::uint64_t content_hash, std::uint64_t most_bytes = 1U << 30U)
      : content_(content_hash), fetch(kJoiner, content_hash, most_bytes) {}

  SceneServer& AddServer(PeerId peer, const std::filesystem::path& scene,
                         std::uint64_t rate = SceneServer::kDefaultRate) {
    const std::uint64_t content = content_;
    auto server = std::make_unique<SceneServer>(
        peer, content,
        [scene](const std::atomic<bool>& stop) {
          return SceneFiles::Open(scene, HashesOf(scene).digest, stop);
        },
        rate);
    SceneServer& made = *server;
    Add(peer, std::move(server));
    return made;
  }
  void Add(PeerId peer, std::unique_ptr<TransferEndpoint> party) {
    servers[peer].party = std::move(party);
  }

  /// Goes on until the fetching side is in none of these states, or for so long.
  void RunWhile(const std::vector<SceneFetch::State>& states, double seconds) {
    const auto until_ns = now_ns + static_cast<std::int64_t>(1e9 * seconds);
    while (now_ns < until_ns && std::ranges::find(states, fetch.state()) != states.end()) Step();
  }
  /// Goes on until a list waits for its consent.
  void RunToList() { RunWhile({SceneFetch::State::kLooking, SceneFetch::State::kListing}, 20); }
  void RunToEnd(double seconds) {
    RunWhile(
        {SceneFetch::State::kFetching, SceneFetch::State::kLooking, SceneFetch::State::kListing},
        seconds);
  }

  void Step() {
    now_ns += kMs / 4;
    if (now_ns >= fetch_next_ns) {
      TransferEndpoint::Out out;
      out.ask = [this](const FileAsk& ask) {
        FileAsk sent = ask;
        sent.program = kJoiner;
        if (Arrives()) asks_.push_back({now_ns, sent});
      };
      fetch_next_ns = fetch.Tick(now_ns, out);
    }
    while (!asks_.empty() && asks_.front().first + delay_ns <= now_ns) {
      for (auto& [peer, server] : servers) {
        if (!server.here) continue;
        server.party->OnAsk(asks_.front().second, now_ns);
        server.next_ns = now_ns;
      }
      asks_.pop_front();
    }
    for (auto& [peer, server] : servers) {
      TransferEndpoint::Out out;
      out.piece = [&, id = peer](const FilePiece& piece) {
        FilePiece sent = piece;
        sent.program = 1000 + id;
        server.sent_bytes += sent.bytes.size();
        if (server.spoil) server.spoil(sent);
        if (Arrives()) pieces_.push_back({now_ns, sent});
      };
      out.listeners = [] {
        return std::size_t{1};
      };
      for (int i = 0; i < 64 && server.here && server.next_ns <= now_ns; ++i) {
        server.next_ns = server.party->Tick(now_ns, out);
      }
    }
    while (!pieces_.empty() && pieces_.front().first + delay_ns <= now_ns) {
      fetch.OnPiece(pieces_.front().second, now_ns);
      pieces_.pop_front();
    }
  }

  std::map<PeerId, Server> servers;
  std::int64_t now_ns = 1'000'000'000;
  std::int64_t delay_ns = kMs;
  double loss = 0;

 private:
  bool Arrives() { return std::uniform_real_distribution<>(0, 1)(random_) >= loss; }

  std::uint64_t content_;
  std::mt19937 random_{7};
  std::deque<std::pair<std::int64_t, FileAsk>> asks_;
  std::deque<std::pair<std::int64_t, FilePiece>> pieces_;
  std::int64_t fetch_next_ns = 0;

 public:
  SceneFetch fetch;
};

}  // namespace tandem::testing
