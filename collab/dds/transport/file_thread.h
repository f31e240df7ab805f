#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include <pthread.h>

#include "collab/dds/cyclone/dds_api.h"
#include "collab/dds/cyclone/partitions.h"
#include "collab/session/messages.h"
#include "collab/session/transport.h"
#include "collab/transfer/file_messages.h"

namespace tandem {

/// Gives a TransferEndpoint the topics file/ask and file/piece of a session while it wants them, on
/// a separate thread. The thread of a serving party runs at a low priority. A writer's samples
/// count as its peer's only if they come by that peer's partition. A WriterRateLimiter refuses more
/// than a sound program sends.
class FileThread {
 public:
  struct Options {
    dds_entity_t participant = 0;
    PeerId self = 0;
    Role role = Role::kActive;
  };

  /// Returns null if the thread or the topics cannot be made, because keys do not allow them or DDS
  /// has no more room.
  static std::unique_ptr<FileThread> Start(const Options& options, TransferEndpoint& party,
                                           Inbox& inbox);
  /// Stops the thread.
  ~FileThread();
  FileThread(const FileThread&) = delete;
  FileThread& operator=(const FileThread&) = delete;

 private:
  FileThread(const Options& options, TransferEndpoint& party, Inbox& inbox);
  bool Open();
  void Close();
  dds_entity_t Topic(const dds_topic_descriptor_t& type, const char* name);
  dds_entity_t Reader(dds_entity_t topic, const char* partition);
  dds_entity_t Writer(dds_entity_t topic);
  void Run();
  template <typename Wire, typename Message, typename Use>
  void TakeAll(dds_entity_t reader, Message& message, const Use& use);
  const WriterFacts& Facts(dds_entity_t reader, dds_instance_handle_t writer);
  void Send(const FileAsk& ask) const;
  void Send(const FilePiece& piece) const;
  std::size_t Listeners() const;

  const Options options_;
  TransferEndpoint& party_;
  Inbox& inbox_;
  const dds_entity_t stop_;
  std::vector<dds_entity_t> readers_;
  std::vector<dds_entity_t> topics_;
  dds_entity_t ask_writer_ = 0;
  dds_entity_t piece_writer_ = 0;
  std::map<dds_instance_handle_t, WriterFacts> facts_;
  FileAsk ask_;
  FilePiece piece_;
  bool open_ = false;
  bool runs_ = false;
  pthread_t thread_{};
};

}  // namespace tandem
