#pragma once

#include <map>
#include <mutex>

#include "collab/dds/dds_api.h"

namespace tandem {

/// Matched writers that have been silent for their lease. Told by a reader's listener, asked by the
/// control thread.
///
/// Cyclone tells from one thread that a silence begins and from another that it ends, and either
/// may come first: where a program was stopped, both are due at once when it goes on. So each
/// writer's begins and ends are counted, and their order says nothing.
class QuietWriters {
 public:
  /// Makes a listener for a reader; `on_change` is a guard condition that it raises, also when
  /// writers come or go. This must outlive the reader.
  Listener MakeListener(dds_entity_t on_change) {
    on_change_ = on_change;
    Listener listener(dds_create_listener(this));
    dds_lset_liveliness_changed(
        listener.get(), [](dds_entity_t, const dds_liveliness_changed_status_t status, void* self) {
          static_cast<QuietWriters*>(self)->Note(status);
        });
    dds_lset_subscription_matched(
        listener.get(), [](dds_entity_t, const dds_subscription_matched_status_t, void* self) {
          dds_set_guardcondition(static_cast<QuietWriters*>(self)->on_change_, true);
        });
    return listener;
  }

  bool Has(dds_instance_handle_t writer) const {
    const std::lock_guard lock(mutex_);
    const auto found = silences_.find(writer);
    return found != silences_.end() && found->second > 0;
  }
  /// Forgets one that is gone.
  void Forget(dds_instance_handle_t writer) {
    const std::lock_guard lock(mutex_);
    silences_.erase(writer);
  }

 private:
  // of writers that are announced and fall silent without being heard, for ever anew
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
      // with no change at all a begin and an end were told as one
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
  std::map<dds_instance_handle_t, int> silences_;  // begun and not ended; below 0: ended before
  dds_entity_t on_change_ = 0;
};

}  // namespace tandem
