#pragma once

#include <functional>

#include "collab/dds/dds_api.h"
#include "collab/dds/writer_gate.h"

namespace tandem {

/// Told of each sample that a reader's gate refused: by which writer, and why. On the thread that
/// received it; takes no lock, allocates nothing.
using OnRefused = std::function<void(dds_instance_handle_t writer, Drop reason)>;

/// Makes a reader with a WriterGate before its cache: what the gate refuses, data or the end of an
/// instance, leaves nothing behind, and its writer is not asked to send it again. A limit of DDS's
/// own would make Cyclone wait for room, on the thread that hears everybody. Negative: Cyclone's code
/// of what went wrong.
dds_entity_t CreateGatedReader(dds_entity_t participant, dds_entity_t topic, const dds_qos_t* qos,
                               const dds_listener_t* listener, const WriterLimits& limits,
                               OnRefused on_refused);

}  // namespace tandem
