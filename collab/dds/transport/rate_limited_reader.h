#pragma once

#include <functional>

#include "collab/dds/cyclone/dds_api.h"
#include "collab/dds/cyclone/writer_rate_limiter.h"

namespace tandem {

/// Takes each sample that a reader's rate limiter refused, with its writer and the reason. It is
/// called on the receiving thread, takes no lock and allocates nothing.
using OnRefused = std::function<void(dds_instance_handle_t writer, Drop reason)>;

/// Makes a reader with a WriterRateLimiter before its cache. A sample that the limiter refuses,
/// data or the end of an instance, leaves nothing behind, and its writer is not asked to send it
/// again. A resource limit of DDS would make Cyclone wait for room instead, on the thread that
/// receives from everybody. Negative: Cyclone's error code.
dds_entity_t CreateRateLimitedReader(dds_entity_t participant, dds_entity_t topic,
                                     const dds_qos_t* qos, const dds_listener_t* listener,
                                     const WriterLimits& limits, OnRefused on_refused);

}  // namespace tandem
