#pragma once

#include "collab/dds/dds_transport.h"

namespace tandem {

/// Cyclone's thread that hears what is said of motion, by its name: there is one in a domain, so
/// that what it calls needs no lock. On loopback the socket of data has a thread to itself, which
/// saves a select() at every packet; elsewhere one waits for all sockets, for one of its own ends
/// only by a packet to its own address, and an address other than loopback's may be gone by then.
const char* ReceiveThreadOf(const DdsOptions& options) noexcept;
bool HasTheSocketToItself(const DdsOptions& options) noexcept;

/// Whether the calling thread is the one of that name. Others of Cyclone's threads call data
/// listeners too, when a writer goes; what they leave untaken, the receive thread takes with the
/// next sample. The first time that it is, it becomes real-time where that is permitted, for
/// Cyclone's configuration does not know all its threads.
bool OnReceiveThread(const char* name) noexcept;

/// Whether a thread of this process may be real-time as the receive thread is: found by trying.
bool RealTimeIsPermitted();

/// The receive threads' priority. Where there is a core for each of them beside the haptic thread's
/// they stand above that: they are short, and carry what it waits for. Else they stand below it, so
/// that no flood of packets keeps it from its frames.
int ReceivePriority() noexcept;
/// The same for a machine of so many cores.
int ReceivePriority(int cores) noexcept;

}  // namespace tandem
