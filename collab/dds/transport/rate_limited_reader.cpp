#include "collab/dds/transport/rate_limited_reader.h"

#include <cstring>
#include <memory>
#include <mutex>
#include <utility>

#include <dds/ddsc/dds_rhc.h>
#include <dds/ddsi/ddsi_rhc.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_tkmap.h>

#include "engine/realtime/clock.h"

extern "C" {
// Cyclone's own cache of a reader. The library exports this function, but its headers do not
// declare it.
dds_rhc* dds_rhc_default_new(dds_reader* reader, const ddsi_sertype* type);
}

namespace tandem {
namespace {

std::uint64_t NumberOf(const ddsi_guid_prefix_t& prefix) {
  static_assert(sizeof prefix == 12);
  std::uint64_t low = 0;
  std::uint32_t high = 0;
  std::memcpy(&low, &prefix, sizeof low);
  std::memcpy(&high, reinterpret_cast<const char*>(&prefix) + sizeof low, sizeof high);
  const std::uint64_t mixed = low ^ (std::uint64_t{high} * 0x9E3779B97F4A7C15U);
  return mixed != 0 ? mixed : 1;
}

/// A reader's cache that asks the limiter first and leaves the rest to Cyclone's cache. Cyclone
/// calls its functions through a table, owns it, and frees it last of all.
struct RateLimitedCache {
  dds_rhc base{};  // first member: Cyclone's pointer to it is the pointer to this
  dds_rhc* inner = nullptr;
  std::mutex mutex;  // guards the limiter: one thread brings data, another the ends of writers
  WriterRateLimiter limiter;
  OnRefused on_refused;

  RateLimitedCache(const WriterLimits& limits, OnRefused reported)
      : limiter(limits), on_refused(std::move(reported)) {}

  static RateLimitedCache& Of(dds_rhc* cache) {
    return *reinterpret_cast<RateLimitedCache*>(cache);
  }
  static RateLimitedCache& Of(ddsi_rhc* cache) {
    return *reinterpret_cast<RateLimitedCache*>(cache);
  }

  static bool Store(ddsi_rhc* cache, const ddsi_writer_info* writer, ddsi_serdata* sample,
                    ddsi_tkmap_instance* instance) {
    RateLimitedCache& self = Of(cache);
    std::optional<Drop> refused;
    {
      const std::scoped_lock lock(self.mutex);
      refused = self.limiter.Refuses(writer->iid, NumberOf(writer->guid.prefix), instance->m_iid,
                                     MonotonicNowNs());
    }
    if (!refused) return dds_rhc_store(self.inner, writer, sample, instance);
    self.on_refused(writer->iid, *refused);
    return true;  // counts as received: Cyclone does not wait for room, nor ask for it again
  }
  static void WriterGone(ddsi_rhc* cache, const ddsi_writer_info* writer) {
    RateLimitedCache& self = Of(cache);
    {
      const std::scoped_lock lock(self.mutex);
      self.limiter.Forget(writer->iid);
    }
    dds_rhc_unregister_wr(self.inner, writer);
  }
  static void RelinquishOwnership(ddsi_rhc* cache, std::uint64_t writer) {
    dds_rhc_relinquish_ownership(Of(cache).inner, writer);
  }
  static void SetQos(ddsi_rhc* cache, const dds_qos* qos) { dds_rhc_set_qos(Of(cache).inner, qos); }
  static void Free(ddsi_rhc* cache) {
    const std::unique_ptr<RateLimitedCache> self(&Of(cache));
    if (self->inner != nullptr) dds_rhc_free(self->inner);
  }
  static std::int32_t Read(dds_rhc* cache, bool lock, void** values, dds_sample_info_t* infos,
                           std::uint32_t most, std::uint32_t mask, dds_instance_handle_t handle,
                           dds_readcond* condition) {
    return dds_rhc_read(Of(cache).inner, lock, values, infos, most, mask, handle, condition);
  }
  static std::int32_t Take(dds_rhc* cache, bool lock, void** values, dds_sample_info_t* infos,
                           std::uint32_t most, std::uint32_t mask, dds_instance_handle_t handle,
                           dds_readcond* condition) {
    return dds_rhc_take(Of(cache).inner, lock, values, infos, most, mask, handle, condition);
  }
  static std::int32_t ReadCdr(dds_rhc* cache, bool lock, ddsi_serdata** values,
                              dds_sample_info_t* infos, std::uint32_t most, std::uint32_t samples,
                              std::uint32_t views, std::uint32_t instances,
                              dds_instance_handle_t handle) {
    return dds_rhc_readcdr(Of(cache).inner, lock, values, infos, most, samples, views, instances,
                           handle);
  }
  static std::int32_t TakeCdr(dds_rhc* cache, bool lock, ddsi_serdata** values,
                              dds_sample_info_t* infos, std::uint32_t most, std::uint32_t samples,
                              std::uint32_t views, std::uint32_t instances,
                              dds_instance_handle_t handle) {
    return dds_rhc_takecdr(Of(cache).inner, lock, values, infos, most, samples, views, instances,
                           handle);
  }
  static bool AddCondition(dds_rhc* cache, dds_readcond* condition) {
    return dds_rhc_add_readcondition(Of(cache).inner, condition);
  }
  static void RemoveCondition(dds_rhc* cache, dds_readcond* condition) {
    dds_rhc_remove_readcondition(Of(cache).inner, condition);
  }
  static std::uint32_t LockSamples(dds_rhc* cache) { return dds_rhc_lock_samples(Of(cache).inner); }
  // the first call of all: without a reader there is no cache of Cyclone's to make
  static dds_return_t Associate(dds_rhc* cache, dds_reader* reader, const ddsi_sertype* type,
                                ddsi_tkmap* instances) {
    RateLimitedCache& self = Of(cache);
    self.inner = dds_rhc_default_new(reader, type);
    if (self.inner == nullptr) return DDS_RETCODE_OUT_OF_RESOURCES;
    return dds_rhc_associate(self.inner, reader, type, instances);
  }
};

constexpr dds_rhc_ops kRateLimitedCache{
    .rhc_ops = {.store = RateLimitedCache::Store,
                .unregister_wr = RateLimitedCache::WriterGone,
                .relinquish_ownership = RateLimitedCache::RelinquishOwnership,
                .set_qos = RateLimitedCache::SetQos,
                .free = RateLimitedCache::Free},
    .read = RateLimitedCache::Read,
    .take = RateLimitedCache::Take,
    .readcdr = RateLimitedCache::ReadCdr,
    .takecdr = RateLimitedCache::TakeCdr,
    .add_readcondition = RateLimitedCache::AddCondition,
    .remove_readcondition = RateLimitedCache::RemoveCondition,
    .lock_samples = RateLimitedCache::LockSamples,
    .associate = RateLimitedCache::Associate};

}  // namespace

dds_entity_t CreateRateLimitedReader(dds_entity_t participant, dds_entity_t topic,
                                     const dds_qos_t* qos, const dds_listener_t* listener,
                                     const WriterLimits& limits, OnRefused on_refused) {
  auto cache = std::make_unique<RateLimitedCache>(limits, std::move(on_refused));
  cache->base.common.ops = &kRateLimitedCache;
  const dds_entity_t reader =
      dds_create_reader_rhc(participant, topic, qos, listener, &cache->base);
  if (reader > 0) static_cast<void>(cache.release());  // the reader owns it
  return reader;
}

}  // namespace tandem
