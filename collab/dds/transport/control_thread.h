#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <thread>

#include "collab/dds/cyclone/dds_api.h"
#include "collab/dds/cyclone/partitions.h"
#include "collab/dds/cyclone/silent_writers.h"
#include "collab/session/messages.h"
#include "collab/session/transport.h"

namespace tandem {

/// Tells the inbox which peers are here and which scenes they offer. It runs a separate thread.
///
/// A peer is here as long as the writer lives by which it was heard. Any writer of the topic can
/// change an instance of peer_info, so the state of an instance proves nothing. The participant
/// that was heard first as a peer has that peer's seat. The thread ignores any other participant
/// that speaks as the same peer until that peer is gone.
class ControlThread {
 public:
  struct Sources {
    dds_entity_t participant = 0;
    dds_entity_t peer_info = 0;  // readers
    dds_entity_t viewer_info = 0;
    dds_entity_t scene = 0;
    dds_entity_t event = 0;          // 0 in a viewer
    dds_entity_t on_match = 0;       // guard condition: writers have come, gone or fallen silent
    SilentWriters* quiet = nullptr;  // silent writers of peer_info and viewer_info
    bool secured = false;            // partitions carry names, which are the members'
    std::set<PeerId> revoked;        // members whose keys are revoked
    std::uint32_t domain = 0;        // number of the DDS domain
  };

  /// Starts the thread. It calls `refresh_owners` first of all, then whenever `on_match` is raised
  /// and when seats change.
  ControlThread(Sources sources, PeerId self, Inbox& inbox,
                std::function<void(const Seats&)> refresh_owners);
  /// Stops the thread. Must not be called from within a call to the inbox.
  ~ControlThread();
  ControlThread(const ControlThread&) = delete;
  ControlThread& operator=(const ControlThread&) = delete;

 private:
  struct PresentPeer {
    dds_entity_t reader = 0;
    dds_instance_handle_t writer = 0;
    std::int64_t twin_ns = 0;  // time since which another participant speaks as this peer too; 0:
                               // none does
  };
  /// A manifest whose author has another participant's seat. A writer sends its manifest only once.
  /// A program that restarts after a crash sends it while its crashed run still has the seat.
  struct WaitingScene {
    SceneManifest manifest;
    std::int64_t since_ns = 0;
    bool reported = false;  // reported as an impostor's, after a while
  };

  void Run();
  template <typename Wire>
  void TakePresence(dds_entity_t reader);
  void TakeScenes();
  /// Hands on the waiting manifests whose writers may speak for their authors by now.
  void ReceiveWaitingScenes();
  /// Hands a manifest on. False: another participant has its author's seat, or another writer
  /// offers in the author's name.
  bool ReceiveScene(const SceneManifest& manifest, dds_instance_handle_t writer);
  void TakeEvents();
  void Receive(PeerInfo& info, dds_entity_t reader, dds_instance_handle_t writer);
  /// Ends the presence of peers whose writers are gone or silent.
  void EndPresence();
  void EndScenes();
  void SayGoodbyes();
  /// Tells the domain's networks which programs are met.
  void NoteMet();
  const WriterFacts& Facts(dds_entity_t reader, dds_instance_handle_t writer);
  /// Returns whether that writer may speak as the peer, by its partition and the peer's seat.
  bool IsOwn(PeerId peer, const WriterFacts& facts) const;

  const Sources sources_;
  const PeerId self_;
  Inbox& inbox_;
  const std::function<void(const Seats&)> refresh_owners_;
  const ProgramId self_program_;
  const dds_entity_t stop_;
  std::map<PeerId, PresentPeer> here_;
  std::map<PeerId, dds_instance_handle_t> offering_;  // writer of the manifest that was heard, by
                                                      // author
  std::map<dds_instance_handle_t, WaitingScene> waiting_scenes_;  // key: writer
  std::map<dds_instance_handle_t, WriterFacts> facts_;
  std::set<PeerId> leaving_;  // peers that have said goodbye
  Seats seats_;
  bool seats_changed_ = false;
  std::thread thread_;
};

}  // namespace tandem
