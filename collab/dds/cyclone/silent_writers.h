#pragma once

#include <map>
#include <mutex>

#include "collab/dds/cyclone/dds_api.h"

namespace tandem {

/// Keeps the matched writers that have been silent for their lease. A reader's listener writes to
/// it, the control thread reads it.
///
/// Cyclone reports the begin of a silence from one thread and its end from another, and either may
/// come first. When a stopped program goes on, both are due at once. So this class counts each
/// writer's begins and ends, whatever their order.
class SilentWriters {
 public:
  /// Makes a listener for a reader. It raises the guard condition `on_change`, also when writers
  /// come or go. This object must outlive the reader.
  Listener MakeListener(dds_entity_t on_change) {
    on_change_ = on_change;
    Listener listener(dds_create_listener(this));
    dds_lset_liveliness_changed(
        listener.get(), [](dds_entity_t, const dds_liveliness_changed_status_t status, void* self) {
          static_cast<SilentWriters*>(self)->Note(status);
        });
    dds_lset_subscription_matched(
        listener.get(), [](dds_entity_t, const dds_subscription_matched_status_t, void* self) {
          dds_set_guardcondition(static_cast<SilentWriters*>(self)->on_change_, true);
        });
    return listener;
  }

  bool Has(dds_instance_handle_t writer) const {
    const std::lock_guard lock(mutex_);
    const auto found = silences_.find(writer);
    return found != silences_.end() && found->second > 0;
  }
  /// Forgets a writer that is gone.
  void Forget(dds_instance_handle_t writer) {
    const std::lock_guard lock(mutex_);
    silences_.erase(writer);
  }

 private:
  // bounds the writers that are announced and fall silent without being heard, again and again
  static constexpr std::size_t kMost = 4096;

  void Note(const dds_liveliness_changed_status_t& status) {
    {
      const std::lock_guard lock(mutex_);
      const dds_instance_handle_t writer = status.last_publication_handle;
      if (status.not_alive_count_change > 0) {
        Count(writer, 1);
      } else if (status.not_alive_count_change < 0 && status.alive_count_change > 0) {
        Count(writer, -1);
      } else if (status.alive_count_change < 0 || status.not_alive_count_change < 0) {
        silences_.erase(writer);  // the writer has gone
      }
      // without a change Cyclone has reported a begin and an end as one
    }
    dds_set_guardcondition(on_change_, true);
  }

  void Count(dds_instance_handle_t writer, int change) {
    if (silences_.size() >= kMost && !silences_.contains(writer))
      silences_.erase(silences_.begin());
    int& silences = silences_[writer];
    silences += change;
    if (silences == 0) silences_.erase(writer);
  }

  mutable std::mutex mutex_;
  std::map<dds_instance_handle_t, int> silences_;  // silences begun minus ended; below 0: the end
                                                   // came first
  dds_entity_t on_change_ = 0;
};

}  // namespace tandem
