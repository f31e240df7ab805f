#pragma once

#include <cstdint>

namespace tandem {

/// The behaviour of a mirror while we push it.
enum class MirrorModel : std::uint8_t {
  kCompliantMirror,  // firm at first, then it gives way as the delay requires: MirrorCompliance
  kHeld,             // rigid at the last received pose
  kDeadReckoned,     // rigid at the pose extrapolated to the present
};

/// Everything that exists to compare: each option takes one part of the simulation away, or puts
/// another in its place. Benchmarks, tests and the lab set them; a session runs with all of them as
/// they are here, but for the contact and the energy gate, which a user may switch off.
struct ExperimentOptions {
  bool contact = true;  // off: bodies pass through one another

  // the schedule of contact tests
  bool coherence = true;  // §5: distance queues; off: every awake point in every frame
  bool chunks = true;     // §5.1: whole chunks by their centre while they are far
  bool drift = true;      // §5.2: points that have not drifted near are not looked up

  // the couplings
  bool energy_gate = true;  // off: the copies of links move without regard to energy
  /// Each end of a link computes the spring between its instance and the copy, sends that force,
  /// and applies the force that it receives. Unstable from a quarter of k_crit on.
  bool exchange_forces = false;
  MirrorModel mirror = MirrorModel::kCompliantMirror;
};

}  // namespace tandem
