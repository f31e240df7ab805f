#include "collab/dds/control/control_domain.h"

#include <array>
#include <cstdlib>
#include <optional>
#include <utility>

#include <sys/stat.h>
#include <unistd.h>

#include "collab/dds/cyclone/cyclone_log.h"
#include "collab/dds/security/permissions.h"
#include "collab/dds/security/security.h"
#include "collab/dds/transport/domain.h"
#include "tandem_control.h"  // idlc's

namespace tandem {

namespace {

namespace fs = std::filesystem;

struct TopicFacts {
  const dds_topic_descriptor_t* type;
  const char* name;
  const char* partition;  // partition of the writers
  bool reliable;
  bool kept;
};

const TopicFacts& FactsOf(ControlTopic topic) {
  static const std::array<TopicFacts, 5> kFacts{{
      {&tandem_control_Request_desc, kControlTopics[0], kHostPartition, true, false},
      {&tandem_control_Answer_desc, kControlTopics[1], kControllerPartition, true, false},
      {&tandem_control_Goal_desc, kControlTopics[2], kHostPartition, false, false},
      {&tandem_control_Scene_desc, kControlTopics[3], kControllerPartition, true, true},
      {&tandem_control_Snapshot_desc, kControlTopics[4], kControllerPartition, false, false},
  }};
  return kFacts[static_cast<std::size_t>(topic)];
}

Qos QosOf(const TopicFacts& facts) {
  Qos qos(dds_create_qos());
  const char* partition = facts.partition;
  dds_qset_partition(qos.get(), 1, &partition);
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  dds_qset_writer_data_lifecycle(qos.get(), true);
  if (!facts.reliable) {
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
    return qos;
  }
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  if (facts.kept) {
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, 1, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  } else {
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 64);
  }
  return qos;
}

dds_entity_t TopicOf(dds_entity_t participant, const TopicFacts& facts) {
  return dds_create_topic(participant, facts.type, facts.name, nullptr, nullptr);
}

}  // namespace

Result<ControlDomain> EnterControlDomain(const std::string& name, std::uint32_t id,
                                         const fs::path& keys) {
  RedirectCycloneLog();
  DdsOptions options;
  options.session = "control/" + name;
  options.domain = id;
  options.interface = "lo";
  Qos qos;
  std::optional<MemberKeys> member;
  if (!keys.empty()) {
    Result<MemberKeys> loaded = LoadMemberKeys(keys);
    if (!loaded) return loaded.error();
    member = *std::move(loaded);
    Result<Qos> secured = SecureParticipantQos(*member);
    if (!secured) return secured.error();
    qos = *std::move(secured);
  }
  Result<Entity> domain = CreateDomain(options);
  if (!domain) return domain.error();
  CycloneLogCapture log;
  ControlDomain control{*std::move(domain), {}};
  control.participant = Entity(dds_create_participant(id, qos.get(), nullptr));
  if (control.participant.get() > 0) return control;
  const std::string logged = log.Take();
  if (member) return Error{ExplainRefusal(logged, *member)};
  return Error{"cannot reach controllers on DDS domain " + std::to_string(id) +
               (logged.empty() ? "" : ": " + ExplainMessage(logged))};
}

Result<fs::path> ControlFolder() {
  // no code of ours sets the environment
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");  // NOLINT(concurrency-mt-unsafe)
  const fs::path folder = runtime != nullptr && *runtime == '/'
                              ? fs::path(runtime) / "tandem"
                              : fs::path("/tmp") / ("tandem-" + std::to_string(getuid()));
  if (mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) {
    return Error{folder.string() + ": cannot be made"};
  }
  struct stat facts {};
  if (lstat(folder.c_str(), &facts) != 0 || !S_ISDIR(facts.st_mode) || facts.st_uid != geteuid() ||
      (facts.st_mode & 0077) != 0) {
    return Error{folder.string() + " is not a folder of yours alone (mode 700): remove it"};
  }
  return folder;
}

std::string ScenesFolderOf(const std::string& controller) {
  return controller + ".scenes";
}

WriterLimits LimitsOf(ControlTopic topic) {
  constexpr int kOneHost = 1;
  // a controller answers every host that comes, and has another id in each session that it joins
  constexpr int kOfAController = 4096;
  // one writer, and for a moment the one before it
  constexpr int kWritersOfOne = 4;
  switch (topic) {
    case ControlTopic::kRequest:
      // a host that asks again at each answer makes some thousands a second, and none may be lost:
      // an emergency stop is a request, too
      return {.per_second = 50'000, .at_once = 50'000, .keys = kOneHost, .of_one = kWritersOfOne};
    case ControlTopic::kGoal:
      // 1 kHz at most, and half a second of it at once
      return {.per_second = 4000, .at_once = 2000, .keys = kOneHost, .of_one = kWritersOfOne};
    case ControlTopic::kScene:
      return {.per_second = 10, .at_once = 100, .keys = kOfAController, .of_one = kWritersOfOne};
    case ControlTopic::kSnapshot:
      return {.per_second = 4000, .at_once = 2000, .keys = kOfAController, .of_one = kWritersOfOne};
    case ControlTopic::kAnswer:
      break;
  }
  return {.per_second = 20'000, .at_once = 20'000, .keys = kOfAController, .of_one = kWritersOfOne};
}

dds_entity_t ControlReader(dds_entity_t participant, ControlTopic topic, OnRefused on_refused) {
  const TopicFacts& facts = FactsOf(topic);
  const dds_entity_t made = TopicOf(participant, facts);
  if (made < 0) return made;
  Qos qos = QosOf(facts);
  // the reader keeps the newest snapshot of each controller; of a host's goals it keeps several,
  // because a goodbye is the last of them
  if (topic == ControlTopic::kGoal) dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 8);
  return CreateRateLimitedReader(participant, made, qos.get(), nullptr, LimitsOf(topic),
                                 std::move(on_refused));
}

dds_entity_t ControlWriter(dds_entity_t participant, ControlTopic topic) {
  const TopicFacts& facts = FactsOf(topic);
  const dds_entity_t made = TopicOf(participant, facts);
  return made < 0 ? made : dds_create_writer(participant, made, QosOf(facts).get(), nullptr);
}

}  // namespace tandem
