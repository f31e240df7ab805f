#pragma once

#include "collab/dds/transport/dds_transport.h"

namespace tandem {

/// Returns the name of the Cyclone thread that receives motion. There is one in a domain, so its
/// callbacks need no lock. On loopback the data socket has a dedicated receive thread, which avoids
/// a select() per packet. On other interfaces one thread serves all sockets. Cyclone stops a
/// dedicated thread by a packet to its own address, and an address other than loopback's may have
/// disappeared by then.
const char* ReceiveThreadOf(const DdsOptions& options) noexcept;
bool HasTheSocketToItself(const DdsOptions& options) noexcept;

/// Returns whether the calling thread has that name. Other threads of Cyclone call data listeners
/// too, when a writer goes; the receive thread takes their samples with its next one. On its first
/// call the receive thread becomes real-time where that is permitted, because Cyclone's
/// configuration does not know all its threads.
bool OnReceiveThread(const char* name) noexcept;

/// Returns whether a thread of this process may be real-time as the receive thread is; it tries it.
bool RealTimeIsPermitted();

/// Returns the receive threads' priority. If each has a core besides the haptic thread's, they
/// stand above that thread: they are short, and it waits for their data. Else they stand below it,
/// so that no flood of packets keeps it from its frames.
int ReceivePriority() noexcept;
/// Returns that priority for a machine with so many cores.
int ReceivePriority(int cores) noexcept;

}  // namespace tandem
