#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <string_view>

#include "collab/dds/wire/wire.h"
#include "collab/session/person_colour.h"
#include "engine/base/text/clean_text.h"
#include "engine/contact/pair/friction.h"
#include "engine/scene/scene.h"

// Converts what is told in words and lists: information on peers and viewers, and the scene.

namespace tandem {
namespace {

// NOLINTBEGIN(modernize-avoid-c-arrays): idlc's arrays are C's

// Copies the text that fits, without cutting a UTF-8 character in two.
template <std::size_t size>
void PutText(std::string_view text, char (&out)[size]) {
  std::size_t length = std::min({text.size(), size - 1, text.find('\0')});
  if (length < text.size()) {
    while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0U) == 0x80U) --length;
  }
  std::memset(out, 0, size);
  std::memcpy(out, text.data(), length);
}

template <std::size_t size>
std::string GetText(const char (&in)[size]) {
  return CleanText(std::string_view(in, strnlen(in, size)));
}

void PutDigest(const Sha256& digest, tandem_Sha256& out) {
  std::copy(digest.begin(), digest.end(), std::begin(out.bytes));
}

Sha256 GetDigest(const tandem_Sha256& in) {
  Sha256 digest{};
  std::copy(std::begin(in.bytes), std::end(in.bytes), digest.begin());
  return digest;
}

// Lets a sequence use `room`, which is only read: dds_write's samples are const.
template <typename Item, typename Sequence>
void Lend(std::vector<Item>& room, Sequence& out) {
  out._maximum = out._length = static_cast<std::uint32_t>(room.size());
  out._buffer = room.data();
  out._release = false;
}

// NOLINTEND(modernize-avoid-c-arrays)

// A number that no colour has counts as no choice.
PersonColour GetColour(std::uint8_t number) {
  return number <= kPersonColours ? number : PersonColour{0};
}

}  // namespace

bool ToWire(const PeerInfo& info, tandem_PeerInfo& wire, InfoBuffers& room) {
  if (info.claims.size() > kMaxClaims || info.beliefs.size() > kMaxClaims) return false;
  wire.peer = info.peer;
  wire.protocol = info.protocol;
  wire.beat = info.beat;
  wire.role = info.role == Role::kViewer ? tandem_VIEWER : tandem_ACTIVE;
  PutText(info.name, wire.name);
  wire.scene_hash = info.scene_hash;
  wire.params_hash = info.params_hash;
  PutDigest(info.scene_digest, wire.scene_digest);
  room.claims.clear();
  for (const Claim& claim : info.claims) {
    room.claims.push_back({.object = claim.object, .epoch = claim.epoch, .held = claim.held});
  }
  Lend(room.claims, wire.claims);
  wire.incarnation = info.incarnation;
  wire.leaving = info.leaving;
  wire.colour = info.colour;
  wire.stopped = info.stopped;
  PutText(info.terms.law, wire.law);
  PutText(info.terms.gains, wire.gains);
  wire.gate = info.terms.gate;
  wire.contact = info.terms.contact;
  wire.force_layer = info.terms.force_layer;
  wire.displacement = info.terms.displacement;
  room.beliefs.clear();
  for (const Belief& belief : info.beliefs) {
    room.beliefs.push_back({.object = belief.object, .peer = belief.peer, .epoch = belief.epoch});
  }
  Lend(room.beliefs, wire.beliefs);
  return true;
}

bool FromWire(const tandem_PeerInfo& wire, PeerInfo& info) {
  if (wire.peer == 0 || wire.claims._length > kMaxClaims || wire.beliefs._length > kMaxClaims) {
    return false;
  }
  if (wire.role != tandem_ACTIVE && wire.role != tandem_VIEWER) return false;
  // also false for NaN
  if (!(std::abs(wire.displacement) <= kWireBounds.position)) return false;
  info.peer = wire.peer;
  info.protocol = wire.protocol;
  info.beat = wire.beat;
  info.role = wire.role == tandem_VIEWER ? Role::kViewer : Role::kActive;
  info.name = GetText(wire.name);
  info.scene_hash = wire.scene_hash;
  info.params_hash = wire.params_hash;
  info.scene_digest = GetDigest(wire.scene_digest);
  info.incarnation = wire.incarnation;
  info.leaving = wire.leaving;
  info.colour = GetColour(wire.colour);
  info.stopped = wire.stopped;
  info.terms = {.law = GetText(wire.law),
                .gains = GetText(wire.gains),
                .gate = wire.gate,
                .contact = wire.contact,
                .force_layer = wire.force_layer,
                .displacement = wire.displacement};
  info.claims.clear();
  info.beliefs.clear();
  if (info.role == Role::kViewer) return true;
  for (std::uint32_t i = 0; i < wire.claims._length; ++i) {
    const tandem_Claim& claim = wire.claims._buffer[i];
    info.claims.push_back({claim.object, claim.epoch, claim.held});
  }
  for (std::uint32_t i = 0; i < wire.beliefs._length; ++i) {
    const tandem_Belief& belief = wire.beliefs._buffer[i];
    info.beliefs.push_back({belief.object, belief.peer, belief.epoch});
  }
  return true;
}

void ToWire(const PeerInfo& info, tandem_ViewerInfo& wire) {
  wire.peer = info.peer;
  wire.protocol = info.protocol;
  wire.beat = info.beat;
  wire.incarnation = info.incarnation;
  wire.leaving = info.leaving;
  wire.colour = info.colour;
  PutText(info.name, wire.name);
}

bool FromWire(const tandem_ViewerInfo& wire, PeerInfo& info) {
  if (wire.peer == 0) return false;
  info = {};
  info.peer = wire.peer;
  info.protocol = wire.protocol;
  info.beat = wire.beat;
  info.role = Role::kViewer;
  info.incarnation = wire.incarnation;
  info.leaving = wire.leaving;
  info.colour = GetColour(wire.colour);
  info.name = GetText(wire.name);
  return true;
}

bool ToWire(const SceneManifest& manifest, tandem_SceneManifest& wire, ManifestBuffers& room) {
  if (manifest.bodies.size() > kMaxSceneBodies) return false;
  wire.offered_by = manifest.offered_by;
  wire.revision = manifest.revision;
  wire.content_hash = manifest.content_hash;
  PutText(manifest.name, wire.name);
  PutText(manifest.file.size() < sizeof wire.file ? manifest.file : std::string(), wire.file);
  wire.voxel_size = manifest.voxel_size;
  wire.contact_stiffness = manifest.contact_stiffness;
  wire.force_layer = manifest.force_layer;
  wire.contact_model = manifest.contact_model;
  wire.friction = manifest.friction;
  room.bodies.clear();
  room.digests.clear();
  for (const BodyDecl& body : manifest.bodies) {
    tandem_BodyDecl& decl = room.bodies.emplace_back();
    PutText(body.name, decl.name);
    decl.values_hash = body.values_hash;
    decl.mesh_hash = body.mesh_hash;
    PutDigest(body.mesh_digest, room.digests.emplace_back());
  }
  Lend(room.bodies, wire.bodies);
  Lend(room.digests, wire.mesh_digests);
  PutDigest(manifest.content_digest, wire.content_digest);
  return true;
}

bool FromWire(const tandem_SceneManifest& wire, SceneManifest& manifest) {
  const auto not_negative = [](double x) {
    return std::isfinite(x) && x >= 0;
  };
  const bool sound =
      wire.offered_by != 0 && wire.revision <= SceneManifest::kUnderWay &&
      wire.bodies._length <= kMaxSceneBodies &&
      (wire.mesh_digests._length == wire.bodies._length || wire.mesh_digests._length == 0) &&
      not_negative(wire.voxel_size) && wire.voxel_size > 0 &&
      not_negative(wire.contact_stiffness) && not_negative(wire.friction) &&
      wire.friction <= kMostFriction &&
      wire.contact_model <= static_cast<std::uint8_t>(ContactModel::kRefined) &&
      wire.force_layer >= 0 && wire.force_layer <= WidestRange(8) - kWarningQueues;
  if (!sound) return false;
  manifest.offered_by = wire.offered_by;
  manifest.revision = wire.revision;
  manifest.content_hash = wire.content_hash;
  manifest.name = GetText(wire.name);
  manifest.file = GetText(wire.file);
  manifest.voxel_size = wire.voxel_size;
  manifest.contact_stiffness = wire.contact_stiffness;
  manifest.force_layer = wire.force_layer;
  manifest.contact_model = wire.contact_model;
  manifest.friction = wire.friction;
  manifest.bodies.clear();
  for (std::uint32_t i = 0; i < wire.bodies._length; ++i) {
    const tandem_BodyDecl& decl = wire.bodies._buffer[i];
    BodyDecl& body = manifest.bodies.emplace_back();
    body.name = GetText(decl.name);
    body.values_hash = decl.values_hash;
    body.mesh_hash = decl.mesh_hash;
    // a program of an older protocol has none
    if (i < wire.mesh_digests._length) {
      body.mesh_digest = GetDigest(wire.mesh_digests._buffer[i]);
    }
  }
  manifest.content_digest = GetDigest(wire.content_digest);
  return true;
}

}  // namespace tandem
