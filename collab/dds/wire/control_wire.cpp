#include "collab/dds/wire/control_wire.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "collab/controller/plain.h"
#include "engine/base/text/clean_text.h"

namespace tandem {

namespace {

constexpr std::uint8_t kAnyNews = 0;
constexpr std::uint8_t kAskedNews = 1;
constexpr std::size_t kMostWarnings = 16;  // bound of idl/tandem_control.idl

template <std::size_t N>
bool SetWords(char (&to)[N], const std::string& text) {
  std::size_t length = std::min(text.size(), N - 1);
  // not within a character of UTF-8
  while (length > 0 && length < text.size() && (text[length] & 0xC0) == 0x80) --length;
  std::memcpy(to, text.data(), length);
  to[length] = '\0';
  return length == text.size();
}

void SetPose(const PlainPose& X, tandem_control_Pose& wire) {
  std::ranges::copy(X.p_W, wire.p);
  std::ranges::copy(X.q_W, wire.q);
}

PlainPose ReadPose(const tandem_control_Pose& wire) {
  PlainPose X;
  std::ranges::copy(wire.p, X.p_W.begin());
  std::ranges::copy(wire.q, X.q_W.begin());
  return X;
}

void SetVector(const std::array<double, 3>& v, double (&wire)[3]) {
  std::ranges::copy(v, wire);
}

std::array<double, 3> ReadVector(const double (&wire)[3]) {
  return {wire[0], wire[1], wire[2]};
}

bool IsSoundVector(const double (&v)[3]) {
  return std::ranges::all_of(v, [](double x) {
    return std::isfinite(x) && std::abs(x) < 1e4;
  });
}

/// Lets a sequence of the wire use a vector's memory.
template <typename Sequence, typename T>
void LendList(std::vector<T>& room, Sequence& sequence) {
  sequence._maximum = sequence._length = static_cast<std::uint32_t>(room.size());
  sequence._buffer = room.data();
  sequence._release = false;
}

struct SetRequest {
  tandem_control_Request* wire;

  bool File(tandem_control_RequestKind kind, const std::string& file) {
    wire->kind = kind;
    return SetWords(wire->file, file);
  }
  bool Name(tandem_control_RequestKind kind, const std::string& name) {
    wire->kind = kind;
    return SetWords(wire->name, name);
  }
  bool Value(tandem_control_RequestKind kind, double value) {
    wire->kind = kind;
    wire->value = value;
    return true;
  }

  bool operator()(const LoadSceneRequest& r) { return File(tandem_control_LOAD_SCENE, r.file); }
  bool operator()(const LoadMeshRequest& r) {
    wire->is_fixed = r.fixed;
    wire->is_shared = r.shared;
    wire->value = r.mass_kg;
    return SetWords(wire->name, r.body) && File(tandem_control_LOAD_MESH, r.file);
  }
  bool operator()(const VoxelizeRequest& r) {
    return Value(tandem_control_VOXELIZE, r.voxel_size_m) && SetWords(wire->file, r.file);
  }
  bool operator()(const GrabRequest& r) {
    wire->has_point = r.grasp_W.has_value();
    if (r.grasp_W) SetVector(*r.grasp_W, wire->point);
    return Name(tandem_control_GRAB, r.body);
  }
  bool operator()(const ReleaseRequest&) { return Value(tandem_control_RELEASE, 0); }
  bool operator()(const GiveRequest& r) { return Name(tandem_control_GIVE, r.peer); }
  bool operator()(const AskForRequest& r) { return Name(tandem_control_ASK_FOR, r.body); }
  bool operator()(const SetParameterRequest& r) {
    return Value(tandem_control_SET_PARAMETER, r.value) && SetWords(wire->name, r.name);
  }
  bool operator()(const SetClearanceRequest& r) {
    wire->whole = r.force_layer;
    return Value(tandem_control_SET_CLEARANCE, r.displacement_m);
  }
  bool operator()(const SaveRequest& r) { return File(tandem_control_SAVE, r.file); }
  bool operator()(const RetraceRequest& r) {
    wire->whole = static_cast<std::int32_t>(r.to);
    return Value(tandem_control_RETRACE, 0);
  }
  bool operator()(const SnapshotRateRequest& r) {
    return Value(tandem_control_SNAPSHOT_RATE, r.rate_hz);
  }
  bool operator()(const EmergencyStopRequest&) { return Value(tandem_control_EMERGENCY_STOP, 0); }
  bool operator()(const ResumeRequest&) { return Value(tandem_control_RESUME, 0); }
  bool operator()(const SetViewRequest& r) {
    std::ranges::copy(r.q_WV, wire->rotation);
    return Value(tandem_control_SET_VIEW, 0);
  }
  bool operator()(const MeasureDistancesRequest& r) {
    wire->whole = r.on ? 1 : 0;
    return Value(tandem_control_MEASURE_DISTANCES, 0);
  }
  bool operator()(const QuitRequest&) { return Value(tandem_control_QUIT, 0); }
};

}  // namespace

std::string TextFromWire(const char* text) {
  return CleanText(text);
}

bool ToWire(const ControlRequest& request, tandem_control_Request& wire) {
  wire.version = kControlVersion;
  return std::visit(SetRequest{&wire}, request);
}

std::optional<ControlRequest> FromWire(const tandem_control_Request& wire) {
  if (!std::isfinite(wire.value) || !IsSoundVector(wire.point)) return std::nullopt;
  const std::string file = TextFromWire(wire.file);
  const std::string name = TextFromWire(wire.name);
  switch (wire.kind) {
    case tandem_control_LOAD_SCENE:
      return LoadSceneRequest{file};
    case tandem_control_LOAD_MESH:
      return LoadMeshRequest{file, name, wire.is_fixed, wire.is_shared, wire.value};
    case tandem_control_VOXELIZE:
      return VoxelizeRequest{file, wire.value};
    case tandem_control_GRAB: {
      GrabRequest grab{.body = name, .grasp_W = std::nullopt};
      if (wire.has_point) grab.grasp_W = ReadVector(wire.point);
      return grab;
    }
    case tandem_control_RELEASE:
      return ReleaseRequest{};
    case tandem_control_GIVE:
      return GiveRequest{name};
    case tandem_control_ASK_FOR:
      return AskForRequest{name};
    case tandem_control_SET_PARAMETER:
      return SetParameterRequest{name, wire.value};
    case tandem_control_SET_CLEARANCE:
      return SetClearanceRequest{wire.whole, wire.value};
    case tandem_control_SAVE:
      return SaveRequest{file};
    case tandem_control_RETRACE:
      if (wire.whole < 0 || wire.whole > 2) return std::nullopt;
      return RetraceRequest{static_cast<RetraceRequest::To>(wire.whole)};
    case tandem_control_SNAPSHOT_RATE:
      return SnapshotRateRequest{wire.value};
    case tandem_control_EMERGENCY_STOP:
      return EmergencyStopRequest{};
    case tandem_control_RESUME:
      return ResumeRequest{};
    case tandem_control_QUIT:
      return QuitRequest{};
    case tandem_control_MEASURE_DISTANCES:
      return MeasureDistancesRequest{wire.whole != 0};
    case tandem_control_SET_VIEW: {
      SetViewRequest view;
      std::ranges::copy(wire.rotation, view.q_WV.begin());
      return view;
    }
  }
  return std::nullopt;
}

void ToWire(const HostAnswer& answer, tandem_control_Answer& wire) {
  wire.host = answer.host;
  wire.number = answer.number;
  wire.ok = answer.answer.ok;
  SetWords(wire.reason, answer.answer.reason);
}

HostAnswer FromWire(const tandem_control_Answer& wire) {
  return {wire.host, wire.number, {wire.ok, TextFromWire(wire.reason)}};
}

void ToWire(const HostGoal& goal, tandem_control_Goal& wire) {
  wire.seq = goal.seq;
  wire.kind = static_cast<tandem_control_GoalKind>(goal.kind);
  SetPose(Plain(goal.X_WG), wire.pose);
  SetVector(Plain(goal.linear), wire.linear);
  SetVector(Plain(goal.angular), wire.angular);
}

bool FromWire(const tandem_control_Goal& wire, HostGoal& goal) {
  if (wire.kind > tandem_control_GOAL_GOODBYE) return false;
  if (!IsSoundVector(wire.pose.p) || !IsSoundVector(wire.linear) || !IsSoundVector(wire.angular))
    return false;
  const Pose X_WG = AsPose(ReadPose(wire.pose));
  const double length = X_WG.q.norm();
  if (!(std::abs(length - 1.0) < 1e-3)) return false;
  goal.kind = static_cast<HostGoal::Kind>(wire.kind);
  goal.seq = wire.seq;
  goal.X_WG = {X_WG.q.normalized(), X_WG.p};
  goal.linear = AsVec3(ReadVector(wire.linear));
  goal.angular = AsVec3(ReadVector(wire.angular));
  return true;
}

void ToWire(const ControlScene& scene, bool loading, tandem_control_Scene& wire,
            std::vector<tandem_control_SceneBody>& room) {
  wire.version = kControlVersion;
  wire.number = scene.number;
  wire.loading = loading;
  SetWords(wire.session, scene.session);
  SetWords(wire.file, scene.file);
  room.clear();
  for (const ControlScene::Body& body : scene.bodies) {
    tandem_control_SceneBody& to = room.emplace_back();
    SetWords(to.name, body.name);
    to.is_fixed = body.fixed;
    to.is_shared = body.shared;
  }
  LendList(room, wire.bodies);
}

void ToWire(const ControllerSnapshot& snapshot, std::uint64_t controller,
            tandem_control_Snapshot& wire, SnapshotBuffers& room) {
  wire.controller = controller;
  wire.scene_number = snapshot.scene_number;
  wire.frame = snapshot.frame;
  wire.time_ns = snapshot.time_ns;
  const SnapshotHand& hand = snapshot.hand;
  wire.hand.input = static_cast<std::uint8_t>(hand.input);
  wire.hand.state = static_cast<std::uint8_t>(hand.state);
  wire.hand.host = hand.host;
  wire.hand.body = static_cast<std::int32_t>(hand.body);
  SetPose(hand.X_WG, wire.hand.X_WG);
  SetPose(hand.goal, wire.hand.goal);
  SetPose(hand.limited_goal, wire.hand.limited_goal);
  SetVector(hand.force_N, wire.hand.force);
  SetVector(hand.torque_Nm, wire.hand.torque);
  wire.hand.felt = hand.felt_N;
  const SnapshotSafety& safety = snapshot.safety;
  wire.safety.state = static_cast<std::uint8_t>(safety.state);
  const std::array counts{safety.clamped, safety.slewed, safety.zeroed, safety.expired,
                          safety.stops};
  std::ranges::copy(counts, wire.safety.counts);
  wire.contact_points = snapshot.contact_points;
  wire.distance.m = snapshot.distance.m;
  wire.distance.error = snapshot.distance.error_m;
  wire.distance.other = static_cast<std::int32_t>(snapshot.distance.other);
  SetVector(snapshot.distance.p_W, wire.distance.p);
  SetVector(snapshot.distance.p_other_W, wire.distance.p_other);
  wire.news_count = snapshot.news_count;
  SetWords(wire.news, snapshot.news);

  room.bodies.resize(snapshot.bodies.size());
  for (std::size_t i = 0; i < room.bodies.size(); ++i) {
    const SnapshotBody& body = snapshot.bodies[i];
    SetPose(body.X_WB, room.bodies[i].X_WB);
    SetPose(body.X_W, room.bodies[i].X_W);
    room.bodies[i].in_hand = body.in_hand;
    // DDS reads it and never changes it
    auto& holders = const_cast<std::vector<std::uint64_t>&>(body.holders);
    LendList(holders, room.bodies[i].holders);
  }
  room.instances.clear();
  for (const SnapshotInstance& from : snapshot.instances) {
    tandem_control_Instance& instance = room.instances.emplace_back();
    instance.peer = from.peer;
    instance.body = static_cast<std::uint32_t>(from.body);
    SetPose(from.X_W, instance.X_W);
  }
  room.contacts.clear();
  for (const SnapshotContact& from : snapshot.contacts) {
    tandem_control_Contact& contact = room.contacts.emplace_back();
    SetVector(from.p_W, contact.p);
    SetVector(from.n_W, contact.n);
    contact.depth = from.depth_m;
    contact.force = from.force_N;
  }
  room.peers.clear();
  room.colours.clear();
  room.stopped.clear();
  for (const SnapshotPeer& from : snapshot.peers) {
    tandem_control_Peer& peer = room.peers.emplace_back();
    peer.id = from.id;
    SetWords(peer.name, from.name);
    peer.active = from.active;
    peer.here = from.here;
    SetWords(peer.refused, from.refused);
    peer.delay = from.delay_s;
    peer.link_force = from.link_force_N;
    peer.held = {};  // the bodies' holders have it
    room.colours.push_back(from.colour);
    room.stopped.push_back(from.stopped ? 1 : 0);
  }
  wire.colour = snapshot.colour;
  wire.news_kind = snapshot.asked ? kAskedNews : kAnyNews;
  wire.news_body = snapshot.asked ? static_cast<std::int32_t>(snapshot.asked->body) : -1;
  wire.news_peer = snapshot.asked ? snapshot.asked->peer : 0;
  room.warnings.clear();
  for (const std::string& warning : snapshot.warnings) {
    if (room.warnings.size() == kMostWarnings) break;
    SetWords(room.warnings.emplace_back().text, warning);
  }
  LendList(room.colours, wire.peer_colours);
  LendList(room.stopped, wire.peers_stopped);
  wire.warnings._maximum = wire.warnings._length = static_cast<std::uint32_t>(room.warnings.size());
  wire.warnings._buffer = room.warnings.empty() ? nullptr : &room.warnings.data()->text;
  wire.warnings._release = false;
  LendList(room.bodies, wire.bodies);
  LendList(room.instances, wire.instances);
  LendList(room.contacts, wire.contacts);
  LendList(room.peers, wire.peers);
}

bool FromWire(const tandem_control_Snapshot& wire, const tandem_control_Scene& scene,
              ControllerSnapshot& snapshot) {
  if (wire.scene_number != scene.number) return false;
  if (wire.bodies._length != 0 && wire.bodies._length != scene.bodies._length) return false;
  if (wire.hand.input > static_cast<std::uint8_t>(SnapshotHand::Input::kDevice) ||
      wire.hand.state > static_cast<std::uint8_t>(SnapshotHand::State::kStopped) ||
      wire.safety.state > static_cast<std::uint8_t>(SnapshotSafety::State::kSilent) ||
      wire.hand.body >= static_cast<std::int64_t>(wire.bodies._length) ||
      wire.distance.other >= static_cast<std::int64_t>(wire.bodies._length)) {
    return false;
  }
  snapshot = {};
  snapshot.frame = wire.frame;
  snapshot.time_ns = wire.time_ns;
  snapshot.session = TextFromWire(scene.session);
  snapshot.scene = TextFromWire(scene.file);
  snapshot.scene_number = wire.scene_number;
  snapshot.self = wire.controller;
  SnapshotHand& hand = snapshot.hand;
  hand.input = static_cast<SnapshotHand::Input>(wire.hand.input);
  hand.state = static_cast<SnapshotHand::State>(wire.hand.state);
  hand.host = wire.hand.host;
  hand.body = wire.hand.body;
  hand.X_WG = ReadPose(wire.hand.X_WG);
  hand.goal = ReadPose(wire.hand.goal);
  hand.limited_goal = ReadPose(wire.hand.limited_goal);
  hand.force_N = ReadVector(wire.hand.force);
  hand.torque_Nm = ReadVector(wire.hand.torque);
  hand.felt_N = wire.hand.felt;
  snapshot.safety = {.state = static_cast<SnapshotSafety::State>(wire.safety.state),
                     .clamped = wire.safety.counts[0],
                     .slewed = wire.safety.counts[1],
                     .zeroed = wire.safety.counts[2],
                     .expired = wire.safety.counts[3],
                     .stops = wire.safety.counts[4]};
  snapshot.contact_points = wire.contact_points;
  snapshot.distance = {.m = wire.distance.m,
                       .error_m = wire.distance.error,
                       .other = wire.distance.other,
                       .p_W = ReadVector(wire.distance.p),
                       .p_other_W = ReadVector(wire.distance.p_other)};
  snapshot.news_count = wire.news_count;
  snapshot.news = TextFromWire(wire.news);
  for (std::uint32_t i = 0; i < wire.peers._length; ++i) {
    const tandem_control_Peer& from = wire.peers._buffer[i];
    SnapshotPeer& peer = snapshot.peers.emplace_back();
    peer.id = from.id;
    peer.name = TextFromWire(from.name);
    peer.active = from.active;
    peer.here = from.here;
    peer.refused = TextFromWire(from.refused);
    peer.delay_s = from.delay;
    peer.link_force_N = from.link_force;
    if (i < wire.peer_colours._length) peer.colour = wire.peer_colours._buffer[i];
    if (i < wire.peers_stopped._length) peer.stopped = wire.peers_stopped._buffer[i] != 0;
  }
  snapshot.colour = wire.colour;
  const bool known_body = wire.news_body >= 0 && wire.news_body < std::int64_t{wire.bodies._length};
  if (wire.news_kind == kAskedNews && known_body) {
    snapshot.asked = {wire.news_peer, static_cast<std::size_t>(wire.news_body)};
  }
  for (std::uint32_t i = 0; i < wire.warnings._length; ++i) {
    snapshot.warnings.push_back(TextFromWire(wire.warnings._buffer[i]));
  }
  for (std::uint32_t i = 0; i < wire.bodies._length; ++i) {
    const tandem_control_Body& from = wire.bodies._buffer[i];
    SnapshotBody& body = snapshot.bodies.emplace_back();
    body.name = TextFromWire(scene.bodies._buffer[i].name);
    body.fixed = scene.bodies._buffer[i].is_fixed;
    body.shared = scene.bodies._buffer[i].is_shared;
    body.in_hand = from.in_hand;
    body.X_WB = ReadPose(from.X_WB);
    body.X_W = ReadPose(from.X_W);
    body.holders.assign(from.holders._buffer, from.holders._buffer + from.holders._length);
    for (SnapshotPeer& peer : snapshot.peers) {
      if (std::ranges::find(body.holders, peer.id) != body.holders.end()) peer.held.push_back(i);
    }
  }
  for (std::uint32_t i = 0; i < wire.instances._length; ++i) {
    const tandem_control_Instance& from = wire.instances._buffer[i];
    if (from.body < snapshot.bodies.size()) {
      snapshot.instances.push_back({from.peer, from.body, ReadPose(from.X_W)});
    }
  }
  for (std::uint32_t i = 0; i < wire.contacts._length; ++i) {
    const tandem_control_Contact& from = wire.contacts._buffer[i];
    snapshot.contacts.push_back({ReadVector(from.p), ReadVector(from.n), from.depth, from.force});
  }
  return true;
}

}  // namespace tandem
