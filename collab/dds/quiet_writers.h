#pragma once

#include <mutex>
#include <set>

#include "collab/dds/dds_api.h"

namespace tandem {

/// Matched writers that have been silent for their lease. Told by a reader's listener, asked by the
/// control thread.
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
    return quiet_.contains(writer);
  }
  /// Forgets one that is gone.
  void Forget(dds_instance_handle_t writer) {
    const std::lock_guard lock(mutex_);
    quiet_.erase(writer);
  }

 private:
  // of writers that are announced and fall silent without being heard, for ever anew
  static constexpr std::size_t kMost = 4096;

  void Note(const dds_liveliness_changed_status_t& status) {
    {
      const std::lock_guard lock(mutex_);
      if (status.not_alive_count_change > 0) {
        if (quiet_.size() >= kMost) quiet_.erase(quiet_.begin());
        quiet_.insert(status.last_publication_handle);
      } else {
        quiet_.erase(status.last_publication_handle);
      }
    }
    dds_set_guardcondition(on_change_, true);
  }

  mutable std::mutex mutex_;
  std::set<dds_instance_handle_t> quiet_;
  dds_entity_t on_change_ = 0;
};

}  // namespace tandem
