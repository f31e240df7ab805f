#include "collab/peer/peer_node.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tandem {

namespace {

constexpr std::int64_t kInfoPeriodNs = 200'000'000;
// Another scene offered at the same time is heard by then; a later offer comes too late.
constexpr std::int64_t kUnderWayNs = 1'000'000'000;
constexpr std::int64_t kViewPeriodNs = 16'666'667;  // 60 Hz

// Work that falls due within half a call interval is done at this call. Calls are not exact to the
// nanosecond, so work due at a call would otherwise now and then be done at the next.
constexpr std::int64_t kFrameEarlyNs = 500'000;       // calls once a millisecond
constexpr std::int64_t kControlEarlyNs = 10'000'000;  // 50 calls a second

/// Returns whether something due every `period_ns` is due now; keeps the beat without catching up.
bool TakeTurn(std::int64_t now_ns, std::int64_t period_ns, std::int64_t early_ns,
              std::int64_t& next_ns) {
  if (now_ns + early_ns < next_ns) return false;
  next_ns = next_ns + period_ns > now_ns ? next_ns + period_ns : now_ns + period_ns;
  return true;
}

OwnTerms TermsOf(const WorldModel& model, const NodeOptions& options) {
  OwnTerms terms{.parameters = ParametersOf(model.scene), .shared = {}};
  if (options.manifest) terms.scene_digest = options.manifest->content_digest;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    terms.heaviest_kg = std::max(terms.heaviest_kg, model.bodies[b].inertia.mass);
    if (model.scene.bodies[model.object[b]].shared) terms.shared.push_back(model.object[b]);
  }
  return terms;
}

}  // namespace

PeerNode::PeerNode(std::shared_ptr<const WorldModel> model, std::unique_ptr<Device> device,
                   std::uint64_t scene_hash, const NodeOptions& options)
    : model_(std::move(model)),
      options_(options),
      world_(model_, {.workers = options.workers, .experiments = options.peer.experiments}),
      device_(std::move(device)),
      directory_(options.peer.id, scene_hash, options.name, TermsOf(*model_, options)),
      inbox_(options.conditions, directory_, options.waiting),
      peer_(world_, *device_, inbox_, options.peer),
      next_loose_ns_(model_->scene.bodies.size()) {
  info_ = {.peer = options.peer.id,
           .protocol = kProtocol,
           .beat = 0,
           .role = Role::kActive,
           .name = options.name,
           .scene_hash = scene_hash,
           .params_hash = HashOf(ParametersOf(model_->scene)),
           .claims = {},
           .terms = options.terms,
           .beliefs = {}};
  manifest_ = options.manifest
                  ? *options.manifest
                  : ManifestOf(model_->scene, {.content = scene_hash, .bodies = {}}, 0);
  manifest_.offered_by = options.peer.id;
  info_.scene_digest = manifest_.content_digest;
}

void PeerNode::HapticFrame(std::int64_t now_ns) noexcept {
  peer_.Tick(now_ns, outbox_.back());
  outbox_.Publish();
}

void PeerNode::SendEvents(Transport& transport) {
  Event event;
  while (peer_.events().TryPop(event)) transport.Publish(event);
}

bool PeerNode::SendFrame(std::int64_t now_ns, Transport& transport) {
  SendEvents(transport);
  ObjectState parked;
  while (peer_.parked().TryPop(parked)) transport.Publish(parked);
  const Outbox& out = outbox_.Read();
  if (out.seq == seen_seq_) return false;
  seen_seq_ = out.seq;
  // turns go by the frames' own time: the time of the call varies within the millisecond
  const std::int64_t frame_ns = out.view.sample_ns;
  const std::int64_t state_period_ns = std::llround(1e9 / options_.publish_hz);
  if (out.holds && TakeTurn(frame_ns, state_period_ns, kFrameEarlyNs, next_state_ns_)) {
    sent_states_.Add(now_ns, state_period_ns);
    if (out.shared) {
      transport.Publish(out.state, out.links);
    } else {
      transport.Publish(out.state);
    }
  }
  if (out.is_loose &&
      TakeTurn(frame_ns, state_period_ns, kFrameEarlyNs, next_loose_ns_[out.loose.object])) {
    transport.Publish(out.loose);
  }
  if (out.view.count > 0 && TakeTurn(frame_ns, kViewPeriodNs, kFrameEarlyNs, next_view_ns_)) {
    transport.Publish(out.view);
  }
  return true;
}

void SendWhenDone(PeerNode& node, Transport& transport, LoopClock& clock) {
  constexpr int kLooks = 3;
  constexpr std::int64_t kLookAgainNs = 250'000;
  const std::int64_t begin_ns = clock.NowNs();
  std::int64_t now_ns = begin_ns;
  for (int look = 1; !node.SendFrame(now_ns, transport) && look < kLooks; ++look) {
    clock.SleepUntil(begin_ns + look * kLookAgainNs);
    now_ns = clock.NowNs();
  }
}

void PeerNode::ControlFrame(std::int64_t now_ns, Transport& transport) {
  const ClaimList& list = peer_.claims().Read();
  const auto* end = list.claims.begin() + list.count;
  bool changed = !std::equal(list.claims.begin(), end, info_.claims.begin(), info_.claims.end());
  if (changed) info_.claims.assign(list.claims.begin(), end);
  info_.beliefs.assign(list.beliefs.begin(), list.beliefs.begin() + list.belief_count);
  const PeerTable& table = peer_.table().Read();
  info_.terms.force_layer = table.own_layer;
  info_.terms.displacement = table.own_displacement_m;
  changed = changed || info_.stopped != table.own_stopped;
  info_.stopped = table.own_stopped;
  directory_.SetOwnTerms(info_.terms);
  directory_.NotifyOwed();
  directory_.NotifyRefusals(inbox_.drops());
  if (changed) next_info_ns_ = now_ns;
  if (TakeTurn(now_ns, kInfoPeriodNs, kControlEarlyNs, next_info_ns_)) {
    ++info_.beat;
    info_.colour = directory_.ColourFor(info_.beat, info_.colour);
    transport.Publish(info_);
  }
  if (under_way_ns_ == 0) {
    under_way_ns_ = now_ns + kUnderWayNs;
    transport.Publish(manifest_);
  } else if (manifest_.revision == SceneManifest::kSession && now_ns >= under_way_ns_) {
    manifest_.revision = SceneManifest::kUnderWay;
    transport.Publish(manifest_);
  }
}

void PeerNode::Leave(std::int64_t now_ns, Transport& transport) {
  peer_.Leave(now_ns);
  SendEvents(transport);
  transport.Leave();
}

std::vector<std::string> PeerNode::TakeNotifications(const OnHand& on_hand) {
  std::vector<std::string> lines = directory_.TakeNotifications();
  Notification notification;
  while (peer_.notifications().TryPop(notification)) {
    lines.push_back(DescribeNotification(notification, true));
    if (on_hand) on_hand(notification, DescribeNotification(notification, false));
  }
  return lines;
}

std::string PeerNode::DescribeNotification(const Notification& notification, bool typed) const {
  if (notification.kind == Notification::Kind::kNotApart) {
    return "heal: nothing stands between your body and the others'";
  }
  if (notification.kind == Notification::Kind::kCrowded) {
    return "a pair of bodies has more contacts than there is room for, so bodies may sink into one "
           "another here; larger voxels give fewer contacts";
  }
  const std::string body = model_->scene.bodies[notification.object].name;
  const std::string who = directory_.NameOf(notification.peer);
  switch (notification.kind) {
    case Notification::Kind::kInHand:
      return "you hold " + body;
    case Notification::Kind::kAsking:
      return "asking " + who + " for " + body;
    case Notification::Kind::kRefused:
      return who + " holds " + body + ", and its user sees that you ask for it";
    case Notification::Kind::kAsked:
      return who + " asks for " + body + ", which you hold" +
             (typed ? ": 'give " + body + " " + who + "' hands it over" : "");
    case Notification::Kind::kNoAnswer:
      return who + " does not answer: you do not get " + body;
    case Notification::Kind::kLetGo:
      return "you let go of " + body;
    case Notification::Kind::kGiven:
      return "you gave " + body + " to " + who;
    case Notification::Kind::kTaken:
      return who + " took over " + body + ", so your hand let go of it";
    case Notification::Kind::kInherited:
      return "nobody else moves " + body + " any more, so your program keeps it in place";
    case Notification::Kind::kForceStopped:
      return "the force of " + body +
             " is not a number: your hand feels nothing of it until you take it again";
    case Notification::Kind::kApart:
      return "something stands between your " + body + " and that of " + who +
             ": the link between them pulls with at most 3 N";
    case Notification::Kind::kComingBack:
      return "your " + body + " comes back to that of " + who + "; your hand is free until then";
    case Notification::Kind::kNoWayBack:
      return "no way is known that brings your " + body + " to that of " + who;
    case Notification::Kind::kTogether:
      return "nothing stands between your " + body + " and that of " + who + " any more";
    case Notification::Kind::kUncoupled:
      return "more than " + std::to_string(kMaxLinks + 1) + " hold " + body +
             ": your hand is not coupled to that of " + who;
    case Notification::Kind::kStopped:
      return "emergency stop: you get no " + body + " until " + (typed ? "'resume'" : "you resume");
    case Notification::Kind::kNotApart:
    case Notification::Kind::kCrowded:
      break;
  }
  return {};
}

}  // namespace tandem
