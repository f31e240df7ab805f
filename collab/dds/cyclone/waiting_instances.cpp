#include "collab/dds/cyclone/waiting_instances.h"

#include <array>
#include <atomic>
#include <string_view>

#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/ddsi_tkmap.h>
#include <dlfcn.h>
#include <pthread.h>

extern "C" {
// from Cyclone's own headers, which C++ does not compile
struct gcreq;
struct gcreq_queue;
using gcreq_cb_t = void (*)(gcreq*);
gcreq* gcreq_new(gcreq_queue* queue, gcreq_cb_t callback);
void gcreq_free(gcreq* request);
}

namespace tandem {
namespace {

std::atomic<std::int64_t> waiting_requests{0};  // requests of any kind that wait for "gc"
std::atomic<bool> is_bounded{false};
std::atomic<std::uint64_t> instances_refused{0};

// Returns whether this is a receive thread: "recv", or "recvUC" or "recvMC" beside it. Only these
// threads go on without an instance, as if the sample could not be read.
bool OnSomeReceiveThread() noexcept {
  static thread_local const bool receives = [] {
    std::array<char, 16> name{};
    pthread_getname_np(pthread_self(), name.data(), name.size());
    return std::string_view(name.data()).starts_with("recv");
  }();
  return receives;
}

// Returns how many requests may wait when a sample of that type brings a new key.
std::int64_t MostWaiting(const ddsi_serdata* sample) noexcept {
  const std::string_view type = sample->type->type_name;
  const bool comes_again = type == "tandem::ObjectState" || type == "tandem::LinkedState" ||
                           type == "tandem::ViewFrame" || type == "tandem::FileAsk" ||
                           type == "tandem::FilePiece";
  return comes_again ? kMostWaitingInstances : kMostWaitingOfAll;
}

}  // namespace

void BoundWaitingInstances() noexcept {
  is_bounded.store(true, std::memory_order_relaxed);
}

std::uint64_t InstancesRefused() noexcept {
  return instances_refused.load(std::memory_order_relaxed);
}

}  // namespace tandem

extern "C" {
// Replaces Cyclone's functions, because Cyclone finds these before its own.
gcreq* gcreq_new(gcreq_queue* queue, gcreq_cb_t callback) {
  static const auto cyclones =
      reinterpret_cast<decltype(&gcreq_new)>(dlsym(RTLD_NEXT, "gcreq_new"));
  tandem::waiting_requests.fetch_add(1, std::memory_order_relaxed);
  return cyclones(queue, callback);
}

void gcreq_free(gcreq* request) {
  static const auto cyclones =
      reinterpret_cast<decltype(&gcreq_free)>(dlsym(RTLD_NEXT, "gcreq_free"));
  tandem::waiting_requests.fetch_sub(1, std::memory_order_relaxed);
  cyclones(request);
}

ddsi_tkmap_instance* ddsi_tkmap_lookup_instance_ref(ddsi_tkmap* map, ddsi_serdata* sample) {
  const std::int64_t waiting = tandem::waiting_requests.load(std::memory_order_relaxed);
  const bool full = waiting >= tandem::kMostWaitingInstances &&
                    tandem::is_bounded.load(std::memory_order_relaxed) &&
                    waiting >= tandem::MostWaiting(sample);
  if (!full || !tandem::OnSomeReceiveThread()) return ddsi_tkmap_find(map, sample, true);
  ddsi_tkmap_instance* const known = ddsi_tkmap_find(map, sample, false);
  if (known == nullptr) {
    tandem::instances_refused.fetch_add(1, std::memory_order_relaxed);
  }
  return known;
}
}
