// A participant that does not keep to the rules, for the tests:
//   dds_rogue_peer SESSION KEYS PARTITION CLAIMED-ID [ACCESS-PLUGIN]
// With the keys in folder KEYS ("-": none) it publishes states of CLAIMED-ID in PARTITION, alone
// and with links, with an access-control plug-in of its own choice. Says "refused" if it could not
// even begin, else "writing" and then "matched" as soon as any reader takes it for a writer. Ends
// with its input.
#include <cstdio>
#include <string>

#include <poll.h>
#include <unistd.h>

#include "collab/dds/cyclone/cyclone_log.h"
#include "collab/dds/cyclone/qos.h"
#include "collab/dds/security/security.h"
#include "collab/dds/transport/domain.h"
#include "collab/dds/wire/wire.h"
#include "tests/collab/dds/live_peer.h"

namespace {

void SayLine(const char* line) {
  std::puts(line);
  std::fflush(stdout);
}

int Refused(const std::string& why) {
  std::fprintf(stderr, "%s\n", why.c_str());
  SayLine("refused");
  return 0;
}

bool InputEnded() {
  pollfd wait{STDIN_FILENO, POLLIN, 0};
  return poll(&wait, 1, 1) > 0;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace tandem;
  if (argc < 5) return 2;
  const PeerId claimed = std::stoull(argv[4]);
  RedirectCycloneLog();
  Qos participant_qos;
  if (std::string(argv[2]) != "-") {
    Result<MemberKeys> keys = LoadMemberKeys(argv[2]);
    if (!keys) return Refused(keys.error().what);
    Result<Qos> qos = SecureParticipantQos(*keys);
    if (!qos) return Refused(qos.error().what);
    participant_qos = *std::move(qos);
    if (argc > 5) dds_qset_prop(participant_qos.get(), "dds.sec.access.library.path", argv[5]);
  }
  DdsOptions options;
  options.session = argv[1];
  options.interface = "lo";
  const Result<Entity> domain = CreateDomain(options);
  if (!domain) return Refused(domain.error().what);
  const Entity participant(dds_create_participant(options.domain, participant_qos.get(), nullptr));
  if (participant.get() < 0) return Refused("no participant");
  const Qos qos = MakeQos(Purpose::kMotion, argv[3]);
  const auto open = [&](const dds_topic_descriptor_t& type, const char* name) {
    const dds_entity_t topic = dds_create_topic(participant.get(), &type, name, nullptr, nullptr);
    return topic < 0 ? topic : dds_create_writer(participant.get(), topic, qos.get(), nullptr);
  };
  const dds_entity_t states = open(tandem_ObjectState_desc, "state/1");
  const dds_entity_t linked = open(tandem_LinkedState_desc, "link/2");
  if (states < 0 && linked < 0) return Refused("no writer");

  SayLine("writing");
  bool matched = false;
  for (std::uint32_t seq = 0; !InputEnded(); ++seq) {
    tandem_ObjectState state{};
    ToWire(testing::SampleState(claimed, seq), state);
    dds_write(states, &state);
    tandem_LinkedState both{};
    ToWire({testing::SampleState(claimed, seq), testing::SampleLinks(claimed, seq)}, both);
    dds_write(linked, &both);
    for (const dds_entity_t writer : {states, linked}) {
      dds_publication_matched_status_t status{};
      dds_get_publication_matched_status(writer, &status);
      if (status.total_count > 0 && !matched) SayLine("matched");
      matched = matched || status.total_count > 0;
    }
  }
  return 0;
}
