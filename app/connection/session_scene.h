#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>

#include "app/connection/connection_options.h"
#include "collab/session/messages.h"
#include "collab/transfer/file_messages.h"

namespace tandem {

/// A scene that could be fetched, described for the person who decides.
struct OfferedScene {
  std::string name;  // plain text
  std::string from;  // peer's name, plain text
  std::size_t files = 0;
  std::uint64_t bytes = 0;

  /// Returns a line such as "scene bracket, 3 files, 103 MB, from anna".
  std::string Words() const;
};

/// The session whose scene is sought, and the identity to join it with.
struct SessionSceneOptions {
  std::string session;
  PeerId id = 0;
  Role role = Role::kActive;
  ConnectionOptions connection;
  bool from_relay = false;               // true: look through a relay, which hands out no
                                         // files
  std::uint64_t most_bytes = 1U << 30U;  // limit on what is fetched
  /// Shows a line to the person.
  std::function<void(const std::string& line)> say;
  /// Asks the person whether to fetch the scene. Returns in a line why not; empty: yes.
  std::function<std::string(const OfferedScene& offered)> refuses;
  /// Returns a peer's name. Null, or an empty answer: the name is unknown.
  std::function<std::string(PeerId peer)> name_of;
  /// Shows how many bytes are there, several times a second. `of` is 0 while the total is unknown.
  std::function<void(std::uint64_t bytes, std::uint64_t of)> progress;
  std::stop_token stop;
};

/// A session's scene file on this machine, or the reason why there is none.
struct SessionScene {
  std::filesystem::path file;  // empty: there is none
  int exit_code = 0;           // ExitCode that goes with `fault`; 0 without a file: told to stop
  std::string fault;           // one line: what happened, and what to do
};

/// Fetches scenes for a program in a session, from peers that have the files.
class SceneFetcher {
 public:
  SceneFetcher();
  ~SceneFetcher();
  SceneFetcher(const SceneFetcher&) = delete;
  SceneFetcher& operator=(const SceneFetcher&) = delete;

  /// Returns the file party for the transport of the peer `self` (DdsOptions::files). It is idle
  /// except during Fetch(). This object must outlive the transport. `keys`: folder of the session's
  /// keys; empty: a plain session.
  TransferEndpoint* PartyOf(PeerId self, const std::filesystem::path& keys);
  /// The folder of the keys of the session that was joined last. From any thread.
  std::filesystem::path keys() const;
  /// Fetches a scene and blocks meanwhile. Of `options`, the members from `most_bytes` on count.
  /// Called by one thread at a time.
  SessionScene Fetch(const SceneManifest& scene, const SessionSceneOptions& options);

 private:
  class Party;
  std::unique_ptr<Party> party_;
  mutable std::mutex mutex_;
  std::filesystem::path keys_;  // guarded by mutex_
};

/// Joins the session silently, hears which scene it uses, and looks for that scene on this machine.
/// Where it is not here, fetches it from peers that have it. Leaves the session before it returns.
SessionScene FindSessionScene(const SessionSceneOptions& options);

}  // namespace tandem
