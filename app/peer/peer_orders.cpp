#include "app/peer/peer_orders.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include <poll.h>
#include <unistd.h>

#include "engine/base/text/nearest_word.h"
#include "engine/contact/features/edge_contact.h"
#include "engine/contact/pair/clearance.h"

namespace tandem {

namespace {

const Error kTooLong{"a line of more than " + std::to_string(OrderReader::kLongest) +
                     " bytes is not a command and is ignored"};

constexpr std::array<std::string_view, 13> kVerbs{"grab",     "release", "give", "heal",   "layer",
                                                  "displace", "clutch",  "stop", "resume", "peers",
                                                  "network",  "quit",    "help"};
constexpr std::size_t kLongestVerb = 40;  // bytes that are compared

/// Returns the number that a whole word is; nothing: it is none.
template <typename Number>
std::optional<Number> AsNumber(const std::string& word) {
  Number number{};
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (fault != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return number;
}

/// Parses the word of `layer N` or `displace MM`.
Result<Command> ParseClearance(bool layer, const std::string& word, const Scene& scene) {
  const ClearanceBounds bounds = scene.clearance_bounds();
  char text[160];
  Command command;
  if (layer) {
    command.kind = Command::Kind::kLayer;
    const auto number = AsNumber<std::int32_t>(word);
    if (number && *number >= bounds.least_layer && *number <= bounds.most_layer) {
      command.layer = *number;
      return command;
    }
    std::snprintf(text, sizeof text, "layer: expected a whole number from %d to %d, got '%.40s'",
                  bounds.least_layer, bounds.most_layer, word.c_str());
    return Error{text};
  }
  command.kind = Command::Kind::kDisplace;
  const auto number = AsNumber<double>(word);
  if (number && bounds.Allows(1e-3 * *number)) {
    command.metres = 1e-3 * *number;
    return command;
  }
  std::snprintf(text, sizeof text,
                "displace: expected millimetres inwards, from %g to %g (one voxel), got '%.40s'",
                -1e3 * bounds.most_outward, 1e3 * bounds.most_inward, word.c_str());
  return Error{text};
}

}  // namespace

std::vector<std::string> HelpOnOrders() {
  return {
      "commands, one per line:",
      "  grab BODY       take this body in hand; if another peer holds it, ask that peer for it",
      "  release         let go of the body that your hand holds; it stays where it is",
      "  give BODY PEER  hand your body to the peer of that name",
      "  heal            bring your instance and the others' together again when something",
      "                  fixed stands between them",
      "  layer N         set the force layer of the body you hold: with each layer more, force",
      "                  begins a voxel farther from surfaces",
      "  displace MM     move the points of the body you hold this far inwards: less clearance;",
      "                  below 0 outwards: more, up to the scene's clearance_range_voxels",
      "  peers           show a row for each other peer: delay; coupling: stiffness; force: its",
      "                  pull on you; theirs: the pull that it reports at its own end; differ:",
      "                  how unlike these two are; mirror: distance from its body as shown here to",
      "                  the newest pose received; age: time since that pose; dropped: samples",
      "                  dropped, and why",
      "  network FILE    follow another network plan; network off: follow none",
      "  clutch          move your handle alone; your body stays; clutch off: move the body again",
      "  stop            emergency stop: your device gives no force until you resume",
      "  resume          end the emergency stop; the force comes back within a second",
      "  quit            leave the session, as Ctrl-C does"};
}

std::string AnswerTo(const Command& order, const WorldModel& model) {
  char text[240];
  if (order.kind == Command::Kind::kLayer) {
    const bool plain = model.scene.contact == ContactModel::kPlain;
    std::snprintf(
        text, sizeof text,
        "force layer %d for the body you hold, at this peer alone; others keep the scene's layer",
        order.layer);
    if (!plain) {
      const std::size_t length = std::strlen(text);
      std::snprintf(text + length, sizeof text - length,
                    "; force begins %.2f voxels from surfaces, where there is room",
                    kRefinedClearance + order.layer - DefaultForceLayer(model.scene.contact));
    }
    return text;
  }
  if (order.kind == Command::Kind::kStop) {
    return "emergency stop: your hand lets go, and a device gives no force; 'resume' ends it";
  }
  if (order.kind == Command::Kind::kResume)
    return "you may take bodies again; a device's force comes back slowly";
  if (order.kind == Command::Kind::kDisplace) {
    std::snprintf(text, sizeof text,
                  "the points of the body you hold move %g mm %s, at this peer alone; others keep "
                  "theirs in place",
                  1e3 * std::abs(order.metres), order.metres < 0 ? "outwards" : "inwards");
    // in a pair of moving bodies either may be the one with the points
    std::string answer = text;
    for (std::size_t i = 0; i < model.bodies.size(); ++i) {
      const auto remark = GapRemark(model.scene, model.bodies[i], order.metres);
      if (!remark) continue;
      answer += "; '" + model.scene.bodies[model.object[i]].name + "': " + *remark;
    }
    return answer;
  }
  return {};
}

Result<Command> ParseOrder(const std::string& line, const WorldModel& model,
                           const PeerDirectory& directory, bool own_only) {
  std::istringstream words(line);
  std::string verb;
  std::string body;
  std::string peer;
  words >> verb >> body;
  std::getline(words >> std::ws, peer);
  if (verb == "release" && body.empty()) return Command{Command::Kind::kRelease, kNoObject, 0};
  if (verb == "stop" && body.empty()) return Command{Command::Kind::kStop, kNoObject, 0};
  if (verb == "resume" && body.empty()) return Command{Command::Kind::kResume, kNoObject, 0};
  if (verb == "heal" && body.empty()) return Command{Command::Kind::kHeal, kNoObject, 0};
  if ((verb == "layer" || verb == "displace") && !body.empty() && peer.empty()) {
    return ParseClearance(verb == "layer", body, model.scene);
  }
  const bool grab = verb == "grab" && !body.empty() && peer.empty();
  const bool give = verb == "give" && !peer.empty();
  if (!grab && !give) {
    const std::string_view nearest =
        NearestWord(verb.substr(0, kLongestVerb), {kVerbs.begin(), kVerbs.end()});
    const std::string hint =
        nearest.empty() || nearest == verb ? "" : "did you mean '" + std::string(nearest) + "'? ";
    return Error{"'" + line + "' is not a command; " + hint +
                 "commands: grab BODY, release, give BODY PEER, heal, layer N, displace "
                 "MM, clutch, stop, resume, peers, network FILE, quit; 'help' explains them"};
  }
  const int found = model.BodyNamed(body);
  if (found < 0) {
    std::vector<std::string_view> names;
    for (const ObjectId object : model.object) names.push_back(model.scene.bodies[object].name);
    const std::string_view nearest = NearestWord(body.substr(0, kLongestVerb), names);
    return Error{"the scene has no moving body '" + body + "'" +
                 (nearest.empty() ? "" : "; did you mean '" + std::string(nearest) + "'?")};
  }
  const ObjectId object = model.object[static_cast<std::size_t>(found)];
  if (grab && own_only && model.scene.bodies[object].shared) {
    return Error{"'" + body +
                 "' is shared: a peer with other force parameters (--insist) cannot hold it"};
  }
  if (grab) return Command{Command::Kind::kGrab, object, 0};
  const PeerId to = directory.PeerNamed(peer);
  if (to == 0) return Error{"no active peer here is called '" + peer + "'"};
  return Command{Command::Kind::kGive, object, to};
}

std::size_t OrderReader::Read() {
  if (ended_ || (isatty(input_) != 0 && tcgetpgrp(input_) != getpgrp())) return 0;
  pollfd input{input_, POLLIN, 0};
  if (poll(&input, 1, 0) <= 0) return 0;
  std::array<char, 512> buffer;
  const ssize_t size = read(input_, buffer.data(), buffer.size());
  if (size > 0) {
    pending_.append(buffer.data(), static_cast<std::size_t>(size));
    return static_cast<std::size_t>(size);
  }
  ended_ = true;
  // the last line need not end in a newline
  if (!pending_.empty()) pending_ += '\n';
  return 0;
}

std::vector<Result<std::string>> OrderReader::TakeLines() {
  std::vector<Result<std::string>> lines;
  std::size_t taken = 0;
  while (lines.size() < kMostLines) {
    const std::size_t end = pending_.find('\n');
    if (end != std::string::npos) {
      const bool tail = std::exchange(too_long_, false);
      if (!tail && end > kLongest) {
        lines.push_back(kTooLong);
      } else if (!tail && end > 0) {
        lines.push_back(pending_.substr(0, end));
      }
      pending_.erase(0, end + 1);
      continue;
    }
    if (pending_.size() > kLongest || too_long_) {
      if (!too_long_) lines.push_back(kTooLong);
      too_long_ = true;
      pending_.clear();
    }
    if (taken >= kMostBytes) break;
    const std::size_t size = Read();
    taken += size;
    if (size == 0 && pending_.find('\n') == std::string::npos) break;
  }
  return lines;
}

}  // namespace tandem
