#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "collab/dds/cyclone/dds_api.h"
#include "collab/dds/cyclone/partitions.h"
#include "collab/dds/cyclone/qos.h"
#include "collab/dds/transport/rate_limited_reader.h"
#include "collab/dds/transport/receive_thread.h"
#include "collab/dds/transport/relay.h"
#include "collab/dds/wire/wire.h"
#include "collab/session/transport.h"
#include "engine/realtime/clock.h"

namespace tandem {

/// Reads a topic of motion. It takes each sample on the receive thread as it comes, passes over
/// samples of its own peer, and hands sound ones to the inbox. It refuses a sample that exceeds its
/// writer's limits, is unsound, or comes through a partition that is not its peer's. The inbox gets
/// the reason. The reader takes no lock that others hold for long, allocates nothing and logs
/// nothing.
/// nothing.
template <typename Wire, typename Message>
class FastReader {
 public:
  using Deliver = void (*)(Inbox& inbox, const Message&, std::int64_t arrival_ns);

  /// Passes over samples of the options' peer. `on_match` is a guard condition that is raised
  /// whenever writers come or go: call RefreshOwners() then.
  FastReader(Inbox& inbox, Deliver deliver, const DdsOptions& options, dds_entity_t on_match)
      : inbox_(inbox),
        deliver_(deliver),
        self_(options.peer),
        thread_(ReceiveThreadOf(options)),
        on_match_(on_match),
        limits_(LimitsOf(Purpose::kMotion, IsBehindRelay(options))) {
    for (std::size_t i = 0; i < kBatch; ++i) pointers_[i] = &samples_[i];
  }

  /// Makes the reader. Negative: Cyclone's error code.
  dds_entity_t Open(dds_entity_t participant, dds_entity_t topic, const Qos& qos) {
    const Listener listener(dds_create_listener(this));
    dds_lset_data_available(listener.get(), [](dds_entity_t reader, void* context) {
      auto* const self = static_cast<FastReader*>(context);
      if (OnReceiveThread(self->thread_)) self->TakeAll(reader);
    });
    dds_lset_subscription_matched(
        listener.get(), [](dds_entity_t, const dds_subscription_matched_status_t, void* self) {
          dds_set_guardcondition(static_cast<FastReader*>(self)->on_match_, true);
        });
    reader_ = CreateRateLimitedReader(participant, topic, qos.get(), listener.get(), limits_,
                                      [this](dds_instance_handle_t writer, Drop reason) {
                                        const PeerId owner = owners_.Find(writer);
                                        inbox_.OnDropped(owner == WriterOwners::kNobody ? 0 : owner,
                                                         reason);
                                      });
    return reader_;
  }

  /// Returns how many writers find no place in the table; their samples are not heard.
  std::size_t RefreshOwners(const Seats& seats) {
    return reader_ > 0 ? owners_.Refresh(reader_, seats) : 0;
  }

 private:
  static constexpr std::size_t kBatch = 16;

  void TakeAll(dds_entity_t reader) noexcept {
    dds_return_t taken = 0;
    do {
      taken = dds_take(reader, pointers_.data(), infos_.data(), kBatch, kBatch);
      const std::int64_t arrival_ns = MonotonicNowNs();
      for (int i = 0; i < taken; ++i) {
        const auto k = static_cast<std::size_t>(i);
        if (infos_[k].valid_data) Hand(samples_[k], infos_[k].publication_handle, arrival_ns);
      }
    } while (taken == static_cast<dds_return_t>(kBatch));
  }

  void Hand(const Wire& wire, dds_instance_handle_t writer, std::int64_t arrival_ns) noexcept {
    if (wire.peer == self_) return;
    const PeerId owner = owners_.Find(writer);
    if (owner == 0) return;  // matched so lately that the table does not know its owner yet
    std::optional<Drop> fault;
    if (owner == WriterOwners::kNobody) {
      fault = Drop::kNoOwner;
    } else if (wire.peer != owner) {
      fault = Drop::kWrongOwner;
    } else {
      fault = FromWire(wire, message_);
    }
    if (fault) {
      inbox_.OnDropped(owner == WriterOwners::kNobody ? 0 : owner, *fault);
    } else {
      deliver_(inbox_, message_, arrival_ns);
    }
  }

  Inbox& inbox_;
  const Deliver deliver_;
  const PeerId self_;
  const char* const thread_;
  const dds_entity_t on_match_;
  const WriterLimits limits_;
  dds_entity_t reader_ = 0;
  WriterOwners owners_;

  // used by the receive thread, which is in one listener of a reader at a time
  std::array<Wire, kBatch> samples_{};
  std::array<void*, kBatch> pointers_{};
  std::array<dds_sample_info_t, kBatch> infos_{};
  Message message_;
};

}  // namespace tandem
