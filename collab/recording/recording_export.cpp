#include "collab/recording/recording_export.h"

#include <algorithm>
#include <array>
#include <cinttypes>
#include <cstdio>

#include "collab/recording/ros2_messages.h"

namespace tandem {
namespace {

std::string IdOf(PeerId peer) {
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%016" PRIx64, peer);
  return digits.data();
}

bool MayBeInTopic(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

std::string ForTopic(std::string name) {
  std::replace_if(
      name.begin(), name.end(),
      [](char c) {
        return !MayBeInTopic(c);
      },
      '_');
  return name;
}

const char* NameOfKind(MembershipChange::Kind kind) {
  switch (kind) {
    case MembershipChange::Kind::kJoined:
      return "joined";
    case MembershipChange::Kind::kLeft:
      return "left";
    case MembershipChange::Kind::kLost:
      return "lost";
    case MembershipChange::Kind::kBack:
      return "back";
    case MembershipChange::Kind::kClaims:
      return "claims";
    case MembershipChange::Kind::kBeliefs:
      return "takes others for the authorities of bodies, and claims";
  }
  return "";
}

const char* NameOfKind(EventKind kind) {
  switch (kind) {
    case EventKind::kAsk:
      return "asks for";
    case EventKind::kGrant:
      return "grants";
    case EventKind::kRefuse:
      return "refuses";
    case EventKind::kRelease:
      return "releases";
    case EventKind::kHeal:
      return "heals";
    case EventKind::kTouch:
      return "touches";
  }
  return "";
}

const char* NameOfKind(Command::Kind kind) {
  switch (kind) {
    case Command::Kind::kGrab:
      return "grab";
    case Command::Kind::kRelease:
      return "release";
    case Command::Kind::kGive:
      return "give";
    case Command::Kind::kHeal:
      return "heal";
    case Command::Kind::kLayer:
      return "layer";
    case Command::Kind::kDisplace:
      return "displace";
    case Command::Kind::kStop:
      return "stop";
    case Command::Kind::kResume:
      return "resume";
    case Command::Kind::kScale:
      return "scale of the device";
  }
  return "";
}

}  // namespace

Result<std::unique_ptr<RecordingExport>> RecordingExport::Create(
    const std::filesystem::path& file, const RecordingHeader& header, const WorldModel& model,
    const std::map<PeerId, std::string>& names) {
  Result<std::unique_ptr<McapWriter>> writer =
      McapWriter::Create(file, "ros2", "tandem " + header.program);
  if (!writer) return writer.error();
  return std::unique_ptr<RecordingExport>(new RecordingExport(*std::move(writer), model, names));
}

RecordingExport::RecordingExport(std::unique_ptr<McapWriter> writer, const WorldModel& model,
                                 const std::map<PeerId, std::string>& names)
    : writer_(std::move(writer)), model_(&model) {
  const auto add = [this](const Ros2Type& type) {
    return writer_->AddSchema(type.name, "ros2msg", type.definition);
  };
  pose_ = add(PoseStampedType());
  twist_ = add(TwistStampedType());
  wrench_ = add(WrenchStampedType());
  number_ = add(Float64Type());
  text_ = add(StringType());
  for (const SceneBody& body : model.scene.bodies) {
    std::string name = ForTopic(body.name);
    if (std::ranges::count(names_, name) > 0)
      name.append("_").append(std::to_string(names_.size()));
    names_.push_back(name);
  }
  std::vector<std::string> taken;
  for (const auto& [peer, called] : names) {
    std::string name = ForTopic(called);
    if (name.empty()) continue;
    // peers with the same name are told apart by their ids
    if (std::ranges::count(taken, name) > 0) name.append("_").append(IdOf(peer));
    taken.push_back(name);
    peers_[peer] = name;
  }
}

std::string RecordingExport::NameOfPeer(PeerId peer) const {
  const auto named = peers_.find(peer);
  return named == peers_.end() ? IdOf(peer) : named->second;
}

std::uint16_t RecordingExport::Channel(const std::string& topic, std::uint16_t schema) {
  constexpr std::size_t kMostChannels = 4096;
  const auto it = channels_.find(topic);
  if (it != channels_.end()) return it->second;
  // a recording made to exceed this has the rest in one channel for each schema
  if (channels_.size() == kMostChannels) return Channel("/more/" + std::to_string(schema), schema);
  if (channels_.size() > kMostChannels + 16) return 0;
  const std::uint16_t channel =
      writer_->AddChannel(schema, topic, "cdr", {{"offered_qos_profiles", ""}});
  channels_[topic] = channel;
  return channel;
}

std::string RecordingExport::NameOf(ObjectId object) const {
  return object < names_.size() ? names_[object] : "body_" + std::to_string(object);
}

void RecordingExport::Add(const RecordedFrame& frame, PeerNode& node) {
  AddWords(frame);
  AddBodies(frame, node);
  AddForces(frame, node);
}

void RecordingExport::AddBodies(const RecordedFrame& frame, const PeerNode& node) {
  const auto time = static_cast<std::uint64_t>(frame.now_ns);
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    const std::string topic = "/bodies/" + NameOf(model_->object[b]);
    const RigidState& state = node.world().state(b);
    writer_->Write(Channel(topic + "/pose", pose_), time, PoseStamped(frame.now_ns, state.X_WB));
    writer_->Write(Channel(topic + "/twist", twist_), time, TwistStamped(frame.now_ns, state.V_WB));
  }
  for (const ObjectState& state : frame.states) {
    writer_->Write(
        Channel("/peers/" + NameOfPeer(state.peer) + "/" + NameOf(state.object) + "/pose", pose_),
        time, PoseStamped(frame.now_ns, state.X_WB));
  }
}

void RecordingExport::AddForces(const RecordedFrame& frame, PeerNode& node) {
  const auto time = static_cast<std::uint64_t>(frame.now_ns);
  const auto wrench = [&](const std::string& topic, const Wrench& F) {
    writer_->Write(Channel(topic, wrench_), time, WrenchStamped(frame.now_ns, F));
  };
  writer_->Write(Channel("/hand/pose", pose_), time, PoseStamped(frame.now_ns, frame.device.X_WA));
  const Peer& peer = node.peer();
  if (peer.held_state() == nullptr) return;
  wrench("/hand/wrench", peer.report().hand_B_W);
  wrench("/contact/wrench", peer.report().contact_B_W);
  if (peer.shared() == nullptr) return;
  std::array<LinkView, kMaxLinks> links;
  const std::size_t count = peer.shared()->Links(frame.now_ns, links);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string topic = "/links/" + NameOfPeer(links[i].peer);
    wrench(topic + "/wrench", peer.report().links_B_W[i]);
    writer_->Write(Channel(topic + "/stiffness", number_), time, Float64(links[i].stiffness));
    writer_->Write(Channel(topic + "/delay", number_), time, Float64(0.5 * links[i].loop_age_s));
  }
}

void RecordingExport::AddWords(const RecordedFrame& frame) {
  const auto say = [&](const std::string& words) {
    writer_->Write(Channel("/events", text_), static_cast<std::uint64_t>(frame.now_ns),
                   String(words));
  };
  for (const MembershipChange& change : frame.changes) {
    std::string words = NameOfPeer(change.peer) + " " + NameOfKind(change.kind);
    for (std::uint32_t i = 0; i < change.claim_count; ++i) {
      words += (i == 0 ? ": " : ", ") + NameOf(change.claims[i].object) +
               (change.claims[i].held ? " in hand" : "");
    }
    say(words);
  }
  for (const Event& event : frame.events) {
    say(NameOfPeer(event.peer) + " " + NameOfKind(event.kind) + " " + NameOf(event.object) +
        (event.to != 0 ? ", to " + NameOfPeer(event.to) : ""));
  }
  for (const Command& command : frame.commands) {
    std::string words("asked here: ");
    words.append(NameOfKind(command.kind));
    if (command.object != kNoObject) words.append(" ").append(NameOf(command.object));
    if (command.kind == Command::Kind::kLayer) {
      words.append(" ").append(std::to_string(command.layer));
    }
    if (command.kind == Command::Kind::kDisplace) {
      words.append(" ").append(std::to_string(1e3 * command.metres)).append(" mm inwards");
    }
    if (command.kind == Command::Kind::kScale) {
      words.append(" ").append(std::to_string(command.metres));
    }
    if (command.to != 0) words.append(" to ").append(NameOfPeer(command.to));
    say(words);
  }
}

}  // namespace tandem
