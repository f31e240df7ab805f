#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "app/reach/reach_options.h"
#include "collab/messages.h"
#include "collab/transfer/file_messages.h"

namespace tandem {

/// A scene that could be fetched, for the person who decides.
struct SceneOffered {
  std::string name;  // plain text
  std::string from;  // the peer's, likewise
  std::size_t files = 0;
  std::uint64_t bytes = 0;

  /// "scene bracket, 3 files, 103 MB, from anna"
  std::string Words() const;
};

/// Whose scene is sought, and as whom.
struct SessionSceneOptions {
  std::string session;
  PeerId id = 0;
  Role role = Role::kActive;
  ReachOptions reach;
  bool from_relay = false;               // look through a relay, which hands out no files
  std::uint64_t most_bytes = 1U << 30U;  // that are fetched
  /// Says a line to the person.
  std::function<void(const std::string& line)> say;
  /// Asks the person whether it is to be fetched; empty: yes, else in a line why not.
  std::function<std::string(const SceneOffered& offered)> refuses;
  /// How a peer is called; null, and for an empty answer: that is not known.
  std::function<std::string(PeerId peer)> name_of;
  /// Shows how many of the bytes are there, of 0 as long as it is not known of how many. Several
  /// times a second.
  std::function<void(std::uint64_t bytes, std::uint64_t of)> progress;
  std::stop_token stop;
};

/// The file of a session's scene on this machine.
struct SessionScene {
  std::filesystem::path file;  // empty: there is none
  int exit_code = 0;           // of ExitCode, with `fault`; 0 and no file: it was told to stop
  std::string fault;           // one line: what happened, and what to do
};

/// Fetches scenes for a program that is in a session, from peers that have their files.
class SceneFetcher {
 public:
  SceneFetcher();
  ~SceneFetcher();
  SceneFetcher(const SceneFetcher&) = delete;
  SceneFetcher& operator=(const SceneFetcher&) = delete;

  /// For the transport of the peer that `self` is (DdsOptions::files); it does nothing but during
  /// Fetch(). This object must outlive the transport.
  FileParty* PartyOf(PeerId self);
  /// Of the options all counts from `most_bytes` on. From one thread at a time, which it takes for
  /// as long as it takes.
  SessionScene Fetch(const SceneManifest& scene, const SessionSceneOptions& options);

 private:
  class Party;
  std::unique_ptr<Party> party_;
};

/// Joins the session without a word, hears which scene it goes by, and looks for that scene on this
/// machine, else fetches it from peers that have it. Has left the session again when it returns.
SessionScene FindSessionScene(const SessionSceneOptions& options);

}  // namespace tandem
