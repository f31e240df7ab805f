#include "tests/fuzz/targets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include <sys/mman.h>
#include <unistd.h>

#include "app/common/poses_file.h"
#include "app/invite/enrolment.h"
#include "app/invite/invitation.h"
#include "app/invite/tls_endpoint.h"
#include "app/picture/picture_file.h"
#include "app/recording/network_plan.h"
#include "app/stability/report/series.h"
#include "app/study/results_table.h"
#include "app/study/study_file.h"
#include "app/study/trial_log.h"
#include "app/study/trial_order.h"
#include "collab/dds/security/keys.h"
#include "collab/dds/security/revocation.h"
#include "collab/lab/case/case_file.h"
#include "collab/lab/sweep/results_file.h"
#include "collab/lab/sweep/sweep_file.h"
#include "collab/receive/link_trace.h"
#include "collab/recording/recording.h"
#include "collab/recording/replay.h"
#include "collab/trace/trace_file.h"
#include "engine/contact/kept/surface_file.h"
#include "engine/geometry/formats/gltf_buffers.h"
#include "engine/geometry/formats/model_3mf.h"
#include "engine/geometry/formats/native_readers.h"
#include "engine/geometry/formats/raw_mesh.h"
#include "engine/geometry/import/declared_unit.h"
#include "engine/haptics/hand_script.h"
#include "engine/scene/scene.h"
#include "engine/voxel/map/voxmap_file.h"
#include "tests/engine/geometry/import/mesh_file_samples.h"
#include "tests/fuzz/fed_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {

namespace {

std::string BytesOf(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void FeedScene(std::string_view bytes) {
  ExpectPlain(LoadScene(FedFile(bytes)));
}

void FeedHand(std::string_view bytes) {
  const Result<HandScript> script = LoadHandScript(FedFile(bytes));
  ExpectPlain(script);
  if (!script) return;
  for (const double t : {0.0, 0.5, 1e6, 1e300}) {
    static_cast<void>(script->IntentAt(t));
    static_cast<void>(script->IntendedTwistAt(t));
    static_cast<void>(script->PushAt(t));
  }
}

void FeedPlan(std::string_view bytes) {
  const Result<NetworkPlan> plan = LoadNetworkPlan(FedFile(bytes));
  ExpectPlain(plan);
  if (plan) static_cast<void>(MostWaiting(*plan, 15));
}

void FeedCase(std::string_view bytes) {
  ExpectPlain(LoadCase(FedFile(bytes)));
}

void FeedSweep(std::string_view bytes) {
  const CaseCheck check = [](const std::string& text,
                             const std::string& name) -> std::optional<Error> {
    const Result<LabCase> parsed = ParseCase(text, name);
    ExpectPlain(parsed);
    if (!parsed) return parsed.error();
    return std::nullopt;
  };
  ExpectPlain(LoadSweep(FedFile(bytes), check));
}

void FeedResults(std::string_view bytes) {
  ExpectPlain(ReadResults(FedFile(bytes)));
}
void FeedPoses(std::string_view bytes) {
  const std::filesystem::path file = FedFile(bytes);
  ExpectPlain(ReadPosesFile(file));
}
void FeedTrace(std::string_view bytes) {
  const Result<NetworkTrace> trace = ReadNetworkTrace(FedFile(bytes));
  ExpectPlain(trace);
  if (trace) static_cast<void>(LinkTrace(trace->rate_hz, trace->there_ms, 3).At(-1));
}
void FeedStudy(std::string_view bytes) {
  const Result<Study> study = LoadStudy(FedFile(bytes));
  ExpectPlain(study);
  if (!study) return;
  // a study that is believed has an order, and columns
  for (const int participant : {0, study->participants - 1}) {
    TANDEM_CHECK(!TrialsOf(*study, participant).empty());
  }
  TANDEM_CHECK(PseudonymsOf(*study).size() == static_cast<std::size_t>(study->participants));
  static_cast<void>(CodebookText(*study));
}
void FeedTrials(std::string_view bytes) {
  ExpectPlain(TrialLog::Read(FedFile(bytes), 2));
}
void FeedSeries(std::string_view bytes) {
  ExpectPlain(ReadSeries(FedFile(bytes)));
}
void FeedPictures(std::string_view bytes) {
  ExpectPlain(ReadPictures(FedFile(bytes)));
}

void FeedHeader(std::string_view bytes) {
  const Result<RecordingHeader> header = ParseHeader(std::string(bytes));
  ExpectPlain(header);
  // a header that is believed can be written again, and is believed again
  if (header) TANDEM_CHECK(ParseHeader(AsText(*header)).has_value());
}

void FeedRecording(std::string_view bytes) {
  const std::filesystem::path file = FedFile(bytes);
  Result<RecordingReader> reader = RecordingReader::Open(file);
  ExpectPlain(reader);
  if (!reader) return;
  while (reader->Next()) {
  }
  for (const auto& [peer, name] : reader->names()) TANDEM_CHECK(IsPlainText(name));
}

const std::shared_ptr<const WorldModel>& TwoBoxes() {
  static const auto model = [] {
    const TriangleMesh plate =
        Transformed(testing::Box(Vec3(0.1, 0.1, 0.01)), {Quat::Identity(), Vec3(0, 0, -0.03)});
    auto made = std::make_shared<WorldModel>(
        *testing::MakeWorldModel({{plate, true}, {testing::Box(Vec3(0.03, 0.02, 0.02))}}, 0.004));
    made->scene.bodies[1].shared = true;
    return std::shared_ptr<const WorldModel>(made);
  }();
  return model;
}

/// Feeds frames, each behind its length in two bytes, as a peer that heard them.
void FeedFrames(std::string_view bytes) {
  constexpr int kMostFrames = 40;
  RecordingHeader header;
  header.law = "p+dd";
  header.peer.id = 1;
  header.peer.held_object = 1;
  std::unique_ptr<Replay> replay;
  for (int i = 0; i < kMostFrames && bytes.size() > 2; ++i) {
    std::uint16_t length = 0;
    std::memcpy(&length, bytes.data(), sizeof length);
    bytes.remove_prefix(2);
    const std::string_view content = bytes.substr(0, length);
    bytes.remove_prefix(content.size());
    const std::optional<RecordedFrame> frame = DecodeFrame(content);
    if (!frame) continue;
    if (!replay) replay = *Replay::Create(header, TwoBoxes());
    replay->Run(*frame);
  }
}

void FeedVoxmap(std::string_view bytes) {
  const Result<Voxmap> voxmap = MapVoxmap(FedFile(bytes));
  ExpectPlain(voxmap);
  if (voxmap) static_cast<void>(voxmap->Count().total());
}

const TriangleMesh& Cuboid() {
  static const TriangleMesh mesh = testing::Box(Vec3(0.006, 0.004, 0.003));
  return mesh;
}

/// Reads a surface at places in and round the cuboid, whose middle is at 128 in all axes of V, and
/// at some that are far from it.
void ReadAllOver(const BodySurface& surface) {
  FieldPushes pushes;
  FieldGradient gradient;
  FieldReadings readings;
  std::array<std::array<float, kBlockPlaces>, 3> lanes;
  std::array<float, kBlockPlaces> values;
  std::array<std::int32_t, kBlockPlaces> kinds;
  for (double z = -9; z < 10; z += 1.3) {
    for (double y = -9; y < 10; y += 1.3) {
      for (double x = -9; x < 10; x += 1.3) {
        const bool is_far = std::abs(x) > 8.5;
        const Vec3 place = Vec3::Constant(128) + (is_far ? 16 : 1) * Vec3(x, y, z);
        surface.field.WithGradients({&place, 1}, &gradient);
        surface.field.Pushes({&place, 1}, 0.6, pushes);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          lanes[axis].fill(static_cast<float>(place[static_cast<Eigen::Index>(axis)]));
        }
        surface.field.Values({}, {lanes[0].data(), lanes[1].data(), lanes[2].data()}, kBlockPlaces,
                             values.data(), kinds.data());
        const PlacedBlock block{.places_F = {lanes[0].data(), lanes[1].data(), lanes[2].data()}};
        surface.field.ReadBlocks({1, 0, 0, 0, 1, 0, 0, 0, 1}, 0.6F, {&block, 1}, values.data(),
                                 &readings);
        static_cast<void>(surface.features.EdgesBeyond(place));
        std::size_t near = 0;
        surface.features.VisitEdgesIn(place - Vec3::Ones(), place + Vec3::Ones(),
                                      [&near](const BodyFeatures::Edge&) {
                                        ++near;
                                      });
      }
    }
  }
}

/// Feeds the bytes as they are, and with the sums that a sound file has.
void FeedSurface(std::string_view bytes) {
  ExpectPlain(MapSurface(FedFile(bytes), Cuboid(), Pose{}, {}));
  std::string sound(bytes);
  BlockFileHeader header;
  if (sound.size() < sizeof header) return;
  std::memcpy(&header, sound.data(), sizeof header);
  const BlockFileSources key = KeyOf(Cuboid(), SurfaceOptions{});
  header.version = kSurfaceFile.version;
  header.bytes = sound.size();
  header.mesh = key.mesh;
  header.settings = key.settings;
  std::memcpy(sound.data(), &header, sizeof header);
  header.checksum = BlockFileChecksum(std::as_bytes(std::span(sound)));
  std::memcpy(sound.data(), &header, sizeof header);
  const Result<BodySurface> surface = MapSurface(FedFile(sound), Cuboid(), Pose{}, {});
  ExpectPlain(surface);
  if (surface) ReadAllOver(*surface);
}

void ExpectSound(const ReadAnswer& answer) {
  for (const TriangleMesh::Triangle& t : answer.mesh.triangles) {
    for (const std::uint32_t corner : t) TANDEM_CHECK(corner < answer.mesh.points.size());
  }
}

void FeedOff(std::string_view bytes) {
  ExpectSound(ReadOff(bytes));
}
void FeedPly(std::string_view bytes) {
  if (const auto answer = ReadPly(bytes)) ExpectSound(*answer);
}
void FeedStl(std::string_view bytes) {
  if (const auto answer = ReadBinaryStl(bytes)) ExpectSound(*answer);
}

/// Returns a file of these bytes under a name, whose ending says what it is.
std::filesystem::path Named(const char* name, std::string_view bytes) {
  static const ScratchFolder folder;
  std::filesystem::path file = folder.path() / name;
  const std::filesystem::path fed = FedFile(bytes);
  if (!std::filesystem::is_symlink(file)) std::filesystem::create_symlink(fed, file);
  return file;
}

void FeedArchive(std::string_view bytes) {
  const std::filesystem::path file = Named("fed.3mf", bytes);
  if (const auto answer = ReadSeveralModels(file, "")) ExpectSound(*answer);
  static_cast<void>(ReadSeveralModels(file, "lid"));
  static_cast<void>(DeclaredUnit(file));
}

/// Feeds the bytes as an archive, and as the model in one whose sums are right.
void Feed3mf(std::string_view bytes) {
  FeedArchive(bytes);
  FeedArchive(testing::Zip({{"3D/3dmodel.model", std::string(bytes)}}));
}

void FeedTexts(std::string_view bytes) {
  for (const char* name : {"fed.dae", "fed.obj", "fed.gltf", "fed.glb"}) {
    const std::filesystem::path file = Named(name, bytes);
    static_cast<void>(TextInstead(file));
    static_cast<void>(SilentFault(file, {}, 3));
    static_cast<void>(GltfBuffers(file));
  }
}

void FeedAnswer(std::string_view bytes) {
  static_cast<void>(ParseAnswer(bytes));
}

/// Feeds the bytes as they come to a listener, to a joiner, and in a line that was sent by mail.
void FeedInvitation(std::string_view bytes) {
  const std::string text(bytes);
  ExpectPlain(ReadInvitation(text));
  ExpectPlain(ReadEnrolmentRequest(text));
  ExpectPlain(ReadEnrolmentAnswer(text));
  static const Result<TlsIdentity> identity = TlsIdentity::Make();
  TANDEM_CHECK(identity.has_value());
  TlsEndpoint end = TlsEndpoint::Server(*identity);
  end.Receive(bytes);
  static_cast<void>(end.Hear());
  static_cast<void>(end.TakeToSend());
  TANDEM_CHECK(!end.open());  // nobody greets in one go
}

constexpr std::array kChanged{"member.txt",         "identity.pem", "identity_ca.pem",
                              "permissions_ca.pem", "revoked.p7s",  "identity.crl"};

/// Feeds a member's keys with one file of them changed: which one in the first byte, where in two,
/// how many bytes go in one, what comes there in the rest.
void FeedKeys(std::string_view bytes) {
  constexpr std::size_t kChange = 4;
  if (bytes.size() < kChange) return;
  struct Made {
    Made() {
      const std::filesystem::path session = scratch.path() / "session";
      const std::filesystem::path gone = scratch.path() / "gone";
      TANDEM_CHECK(MakeSessionKeys(session).has_value());
      TANDEM_CHECK(MakeMemberKeys(session, "gone", Role::kActive, gone).has_value());
      TANDEM_CHECK(RevokeMember(session, gone).has_value());
      TANDEM_CHECK(MakeMemberKeys(session, "anna", Role::kActive, folder).has_value());
      for (const char* name : kChanged) files.push_back(BytesOf(folder / name));
    }
    ScratchFolder scratch;
    std::filesystem::path folder = scratch.path() / "anna";
    std::vector<std::string> files;
  };
  static const Made made;
  const auto byte = [&](std::size_t i) {
    return static_cast<unsigned char>(bytes[i]);
  };
  const std::size_t which = byte(0) % kChanged.size();
  std::string changed = made.files[which];
  const std::size_t at = std::min<std::size_t>(byte(1) + 256U * byte(2), changed.size());
  changed.replace(at, byte(3), bytes.substr(kChange));
  const std::filesystem::path file = made.folder / kChanged[which];
  std::ofstream(file, std::ios::binary) << changed;
  ExpectPlain(LoadMemberKeys(made.folder));
  std::ofstream(file, std::ios::binary) << made.files[which];
}

constexpr std::array<FuzzTarget, 25> kTargets{{{"scene", FeedScene},
                                               {"hand", FeedHand},
                                               {"plan", FeedPlan},
                                               {"case", FeedCase},
                                               {"sweep", FeedSweep},
                                               {"results", FeedResults},
                                               {"poses", FeedPoses},
                                               {"trace", FeedTrace},
                                               {"series", FeedSeries},
                                               {"study", FeedStudy},
                                               {"trials", FeedTrials},
                                               {"pictures", FeedPictures},
                                               {"header", FeedHeader},
                                               {"recording", FeedRecording},
                                               {"frames", FeedFrames},
                                               {"voxmap", FeedVoxmap},
                                               {"surface", FeedSurface},
                                               {"off", FeedOff},
                                               {"stl", FeedStl},
                                               {"ply", FeedPly},
                                               {"3mf", Feed3mf},
                                               {"texts", FeedTexts},
                                               {"answer", FeedAnswer},
                                               {"keys", FeedKeys},
                                               {"invitation", FeedInvitation}}};

}  // namespace

std::filesystem::path FedFile(std::string_view bytes) {
  static const int descriptor = memfd_create("fed", MFD_CLOEXEC);
  TANDEM_CHECK(descriptor >= 0 && ftruncate(descriptor, 0) == 0);
  TANDEM_CHECK(pwrite(descriptor, bytes.data(), bytes.size(), 0) ==
               static_cast<ssize_t>(bytes.size()));
  return "/proc/self/fd/" + std::to_string(descriptor);
}

std::span<const FuzzTarget> FuzzTargets() {
  return kTargets;
}

const FuzzTarget* FuzzTargetNamed(std::string_view name) {
  for (const FuzzTarget& target : kTargets) {
    if (target.name == name) return &target;
  }
  return nullptr;
}

}  // namespace tandem
