#include "collab/dds/transport/file_thread.h"

#include <algorithm>
#include <array>

#include <sys/resource.h>
#include <unistd.h>

#include "collab/dds/cyclone/cyclone_log.h"
#include "collab/dds/cyclone/qos.h"
#include "collab/dds/transport/rate_limited_reader.h"
#include "collab/dds/wire/file_wire.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

// A peer's memory is locked, so a thread costs its whole stack.
constexpr std::size_t kStackBytes = 512U << 10U;
constexpr int kLowPriority = 15;  // nice
constexpr std::size_t kMostKnownFacts = 1024;
// Samples of each writer that may wait in a reader.
constexpr int kAskDepth = 8;
constexpr int kPieceDepth = 48;

constexpr WriterLimits kAskLimits{.per_second = 50, .at_once = 50, .keys = 1, .of_one = 2};
constexpr WriterLimits kPieceLimits{.per_second = 4000, .at_once = 2000, .keys = 1, .of_one = 2};

}  // namespace

FileThread::FileThread(const Options& options, TransferEndpoint& party, Inbox& inbox)
    : options_(options),
      party_(party),
      inbox_(inbox),
      stop_(dds_create_guardcondition(options.participant)) {}

std::unique_ptr<FileThread> FileThread::Start(const Options& options, TransferEndpoint& party,
                                              Inbox& inbox) {
  std::unique_ptr<FileThread> files(new FileThread(options, party, inbox));
  // a party that wants nothing yet opens its topics later
  if (party.wants() && !files->Open()) return nullptr;
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kStackBytes);
  files->runs_ = pthread_create(
                     &files->thread_, &attributes,
                     [](void* self) -> void* {
                       static_cast<FileThread*>(self)->Run();
                       return nullptr;
                     },
                     files.get()) == 0;
  pthread_attr_destroy(&attributes);
  return files->runs_ ? std::move(files) : nullptr;
}

FileThread::~FileThread() {
  party_.Stop();
  if (!runs_) return;
  dds_set_guardcondition(stop_, true);
  pthread_join(thread_, nullptr);
}

dds_entity_t FileThread::Reader(dds_entity_t topic, const char* partition) {
  Qos qos = MakeQos(Purpose::kMotion, partition);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, party_.serves() ? kAskDepth : kPieceDepth);
  const dds_entity_t reader = CreateRateLimitedReader(
      options_.participant, topic, qos.get(), nullptr, party_.serves() ? kAskLimits : kPieceLimits,
      [this](dds_instance_handle_t, Drop reason) {
        inbox_.OnDropped(0, reason);
      });
  if (reader > 0) readers_.push_back(reader);
  return reader;
}

dds_entity_t FileThread::Writer(dds_entity_t topic) {
  const bool looks_on = options_.role == Role::kViewer;
  const Qos qos = MakeQos(Purpose::kMotion,
                          looks_on ? ViewerPartition(options_.self) : PeerPartition(options_.self));
  return dds_create_writer(options_.participant, topic, qos.get(), nullptr);
}

dds_entity_t FileThread::Topic(const dds_topic_descriptor_t& type, const char* name) {
  const dds_entity_t topic = dds_create_topic(options_.participant, &type, name, nullptr, nullptr);
  if (topic > 0) topics_.push_back(topic);
  return topic;
}

bool FileThread::Open() {
  open_ = true;
  const dds_entity_t pieces = Topic(tandem_FilePiece_desc, "file/piece");
  if (party_.serves()) {
    piece_writer_ = Writer(pieces);
    const bool opened =
        piece_writer_ > 0 && Reader(Topic(tandem_FileAsk_desc, "file/ask"), kEveryPeer) > 0;
    // a viewer may not publish file/*: its keys are older than that topic
    Reader(Topic(tandem_FileAsk_desc, "review/file_ask"), kEveryViewer);
    return opened;
  }
  const bool looks_on = options_.role == Role::kViewer;
  ask_writer_ = Writer(Topic(tandem_FileAsk_desc, looks_on ? "review/file_ask" : "file/ask"));
  return ask_writer_ > 0 && Reader(pieces, kEveryPeer) > 0;
}

void FileThread::Close() {
  open_ = false;
  for (const dds_entity_t reader : readers_) dds_delete(reader);  // and its read conditions
  for (const dds_entity_t writer : {ask_writer_, piece_writer_}) {
    if (writer > 0) dds_delete(writer);
  }
  for (const dds_entity_t topic : topics_) dds_delete(topic);
  readers_.clear();
  topics_.clear();
  ask_writer_ = piece_writer_ = 0;
}

const WriterFacts& FileThread::Facts(dds_entity_t reader, dds_instance_handle_t writer) {
  if (const auto known = facts_.find(writer); known != facts_.end()) return known->second;
  if (facts_.size() >= kMostKnownFacts) facts_.clear();
  static const WriterFacts kNone;
  WriterFacts facts = FactsOfWriter(reader, writer);
  if (facts.participant == 0) return kNone;
  return facts_[writer] = std::move(facts);
}

template <typename Wire, typename Message, typename Use>
void FileThread::TakeAll(dds_entity_t reader, Message& message, const Use& use) {
  constexpr std::size_t kBatch = 16;
  std::array<void*, kBatch> samples{};
  std::array<dds_sample_info_t, kBatch> infos{};
  const dds_return_t taken = dds_take(reader, samples.data(), infos.data(), kBatch, kBatch);
  for (int i = 0; i < taken; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (!infos[k].valid_data) continue;
    const auto& wire = *static_cast<const Wire*>(samples[k]);
    const WriterFacts& facts = Facts(reader, infos[k].publication_handle);
    if (facts.participant == 0 || wire.peer == options_.self) continue;
    if (facts.owner.peer != wire.peer) {
      inbox_.OnDropped(facts.owner.peer, Drop::kImpostor);
    } else if (!FromWire(wire, message)) {
      inbox_.OnDropped(wire.peer, Drop::kBadCount);
    } else {
      message.program = facts.participant;
      use(message);
    }
  }
  if (taken > 0) dds_return_loan(reader, samples.data(), taken);
}

void FileThread::Send(const FileAsk& ask) const {
  tandem_FileAsk wire;
  ToWire(ask, wire);
  static_cast<void>(dds_write(ask_writer_, &wire));
}

void FileThread::Send(const FilePiece& piece) const {
  tandem_FilePiece wire;
  ToWire(piece, wire);
  static_cast<void>(dds_write(piece_writer_, &wire));
}

std::size_t FileThread::Listeners() const {
  dds_publication_matched_status_t status{};
  if (dds_get_publication_matched_status(piece_writer_, &status) != DDS_RETCODE_OK) return 1;
  return status.current_count;
}

void FileThread::Run() {
  pthread_setname_np(pthread_self(), "files");
  if (party_.serves()) setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kLowPriority);
  Entity waitset;
  const auto wait_for_readers = [&] {
    waitset = Entity(dds_create_waitset(options_.participant));
    for (const dds_entity_t reader : readers_) {
      dds_waitset_attach(waitset.get(), dds_create_readcondition(reader, DDS_ANY_STATE), 0);
    }
    dds_waitset_attach(waitset.get(), stop_, 0);
  };
  wait_for_readers();
  const TransferEndpoint::Out out{.ask =
                                      [this](const FileAsk& ask) {
                                        Send(ask);
                                      },
                                  .piece =
                                      [this](const FilePiece& piece) {
                                        Send(piece);
                                      },
                                  .listeners =
                                      [this] {
                                        return Listeners();
                                      }};
  std::int64_t next_ns = MonotonicNowNs();
  for (;;) {
    const std::int64_t wait_ns = std::max<std::int64_t>(0, next_ns - MonotonicNowNs());
    dds_waitset_wait(waitset.get(), nullptr, 0, wait_ns);
    bool raised = false;
    if (dds_read_guardcondition(stop_, &raised) == DDS_RETCODE_OK && raised) return;
    if (const bool wants = party_.wants(); wants != open_) {
      waitset.Delete();
      if (!wants) {
        Close();
      } else if (!Open()) {
        ReportDdsMessage("scene files cannot be fetched in this session");
      }
      wait_for_readers();
    }
    const std::int64_t now_ns = MonotonicNowNs();
    for (const dds_entity_t reader : readers_) {
      if (party_.serves()) {
        TakeAll<tandem_FileAsk>(reader, ask_, [&](const FileAsk& ask) {
          party_.OnAsk(ask, now_ns);
        });
      } else {
        TakeAll<tandem_FilePiece>(reader, piece_, [&](const FilePiece& piece) {
          party_.OnPiece(piece, MonotonicNowNs());
        });
      }
    }
    next_ns = party_.Tick(MonotonicNowNs(), out);
  }
}

}  // namespace tandem
