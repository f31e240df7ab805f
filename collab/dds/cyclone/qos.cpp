#include "collab/dds/cyclone/qos.h"

#include "collab/session/messages.h"

namespace tandem {
namespace {

// A listener takes each sample as it comes; the depth covers samples that come while it takes.
constexpr int kMotionDepth = 8;
// Events that may wait at once for a receiver.
constexpr int kEventDepth = 32;

void KeepForLatecomers(dds_qos_t* qos) {
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  // the durability service's history bounds what latecomers get, not the writer's
  dds_qset_durability_service(qos, 0, DDS_HISTORY_KEEP_LAST, 1, DDS_LENGTH_UNLIMITED,
                              DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
}

// Writers of a program on a topic: its own, and another while the first one goes.
constexpr int kWritersOfOne = 4;
constexpr int kWritersOfARelay = 4 * static_cast<int>(kMaxPeers);

}  // namespace

WriterLimits LimitsOf(Purpose purpose, bool behind_relay) {
  const int of_one = behind_relay ? kWritersOfARelay : kWritersOfOne;
  switch (purpose) {
    case Purpose::kMotion:
      // 1 kHz of held bodies, 1 kHz of loose bodies and 5 Hz of kMaxClaims parked bodies; half a
      // second of that at once
      return {.per_second = 4000,
              .at_once = 2000,
              .keys = static_cast<int>(kMaxSceneBodies),
              .of_one = of_one};
    case Purpose::kPresence:
      return {.per_second = 50, .at_once = 100, .keys = 1, .of_one = of_one};
    case Purpose::kSubject:
      // a relay has one for each author
      return {.per_second = 10,
              .at_once = 100,
              .keys = behind_relay ? kWritersOfARelay : kWritersOfOne,
              .of_one = of_one};
    case Purpose::kEvent:
      break;
  }
  // all bodies of a peer may change hands at once, several times
  return {.per_second = 100, .at_once = 8 * static_cast<int>(kMaxClaims), .keys = 1, .of_one = of_one};
}

Qos MakeQos(Purpose purpose, const std::string& partition) {
  Qos qos(dds_create_qos());
  const char* partitions = partition.c_str();  // an array of one
  dds_qset_partition(qos.get(), 1, &partitions);
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  dds_qset_writer_data_lifecycle(qos.get(), false);

  if (purpose == Purpose::kMotion) {
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
    dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, kMotionDepth);
    return qos;
  }
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  if (purpose == Purpose::kEvent) {
    dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, kEventDepth);
    return qos;
  }
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  KeepForLatecomers(qos.get());
  if (purpose == Purpose::kPresence) {
    dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, kLivelinessLeaseNs);
  }
  return qos;
}

}  // namespace tandem
