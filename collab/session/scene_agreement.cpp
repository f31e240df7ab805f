#include "collab/session/scene_agreement.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>

namespace tandem {

std::string BeyondLimits(const Scene& scene) {
  std::size_t moving = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    moving += !scene.bodies[i].fixed && scene.WholeOf(i) == i ? 1 : 0;
  }
  if (moving <= kMaxClaims) return {};
  return scene.file.string() + ": " + std::to_string(moving) +
         " bodies move by themselves, in a session at most " + std::to_string(kMaxClaims) +
         ": fix some, or merge them";
}

SceneManifest ManifestOf(const Scene& scene, const SceneHash& hash, PeerId by) {
  const ForceParameters parameters = ParametersOf(scene);
  SceneManifest manifest{.offered_by = by,
                         .revision = SceneManifest::kSession,
                         .content_hash = hash.content,
                         .name = scene.name,
                         .file = std::filesystem::absolute(scene.file).string(),
                         .voxel_size = parameters.voxel_size,
                         .contact_stiffness = parameters.stiffness,
                         .force_layer = parameters.force_layer,
                         .contact_model = static_cast<std::uint8_t>(parameters.contact),
                         .friction = parameters.friction,
                         .bodies = {},
                         .content_digest = hash.digest};
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    BodyDecl& decl = manifest.bodies.emplace_back();
    decl.name = scene.bodies[i].name;
    if (i >= hash.bodies.size()) continue;
    decl.values_hash = hash.bodies[i].values;
    decl.mesh_hash = hash.bodies[i].mesh;
    decl.mesh_digest = hash.bodies[i].mesh_digest;
  }
  return manifest;
}

ForceParameters ParametersOf(const SceneManifest& manifest) {
  return {.voxel_size = manifest.voxel_size,
          .contact = static_cast<ContactModel>(manifest.contact_model),
          .force_layer = manifest.force_layer,
          .friction = manifest.friction,
          .stiffness = manifest.contact_stiffness};
}

std::string ContentDifference(const Scene& scene, const SceneHash& hash,
                              const SceneManifest& session) {
  if (hash.digest == session.content_digest) return {};
  const std::string of_session = "the session's scene \"" + session.name + "\"";
  for (const BodyDecl& body : session.bodies) {
    if (scene.BodyNamed(body.name) >= 0 || scene.bodies.size() >= session.bodies.size()) continue;
    return scene.file.string() + ": body \"" + body.name + "\" of " + of_session + " is missing";
  }
  for (const SceneBody& body : scene.bodies) {
    const bool known =
        std::any_of(session.bodies.begin(), session.bodies.end(), [&](const BodyDecl& decl) {
          return decl.name == body.name;
        });
    if (known || scene.bodies.size() <= session.bodies.size()) continue;
    return scene.file.string() + ": body \"" + body.name + "\" is not in " + of_session;
  }
  const std::size_t count = std::min(scene.bodies.size(), session.bodies.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::string body = scene.file.string() + ": body \"" + scene.bodies[i].name + "\"";
    if (hash.bodies[i].mesh_digest != session.bodies[i].mesh_digest) {
      return body + ": its file " + scene.bodies[i].mesh.string() + " is not the one of " +
             of_session;
    }
    if (hash.bodies[i].values != session.bodies[i].values_hash) {
      return body + " differs from that of " + of_session +
             " in scale, pose, mass, sharing, constraint, inward shift or point spacing";
    }
  }
  return scene.file.string() + " differs from " + of_session +
         (scene.bodies.size() == session.bodies.size() ? " in gravity or pairs"
                                                       : " in the number of its bodies");
}

std::string PushWarning(const ForceParameters& ours, const ForceParameters& theirs, double mass,
                        const std::string& who) {
  const std::string head = who + " uses other force parameters (" + Describe(theirs) + "; here " +
                           Describe(ours) + "): ";
  const std::optional<UnequalPush> push = ComparePush(ours, theirs, mass);
  if (!push) return head + "you push alike, but what sticks for one may slide for the other";
  const bool we = push->first_harder;
  const std::string pushed = we ? "theirs" : "yours";
  std::array<char, 240> text{};
  if (push->head_start > 0) {
    std::snprintf(text.data(), text.size(),
                  "%s harder; where parts press one another, %s is pushed back from a gap of %.2f "
                  "mm on, %s from %.2f mm, and up to %.0f N a point of contact %s all of it",
                  we ? "you push" : (who + " pushes").c_str(), pushed.c_str(),
                  1e3 * std::max(GapAtFirstForce(ours), GapAtFirstForce(theirs)),
                  we ? "yours" : "theirs",
                  1e3 * std::min(GapAtFirstForce(ours), GapAtFirstForce(theirs)), push->alone_force,
                  we ? "they feel" : "you feel");
  } else {
    std::snprintf(text.data(), text.size(),
                  "%s harder; where parts press one another, %s is pushed back with %.2f times the "
                  "force",
                  we ? "you push" : (who + " pushes").c_str(), pushed.c_str(), push->ratio);
  }
  return head + text.data();
}

bool Precedes(const SceneManifest& a, const SceneManifest& b) {
  return a.revision != b.revision ? a.revision > b.revision : a.offered_by < b.offered_by;
}

bool MayBeAdopted(const ForceParameters& session, const ForceParameters& ours) {
  constexpr double kFactor = 4;
  return session.voxel_size <= kFactor * ours.voxel_size &&
         kFactor * session.voxel_size >= ours.voxel_size;
}

bool SceneOffers::Rank::operator<(const Rank& other) const {
  if (here != other.here) return here;
  if (revision != other.revision) return revision > other.revision;
  if (followers != other.followers) return followers > other.followers;
  return by < other.by;
}

SceneOffers::Rank SceneOffers::RankOf(const Offer& offer) const {
  const SceneManifest& manifest = offer.manifest;
  Rank rank{.here = offer.here, .by = manifest.offered_by};
  const bool takes_part = present_.contains(manifest.offered_by);
  rank.revision =
      takes_part ? manifest.revision : std::min(manifest.revision, SceneManifest::kSession);
  if (rank.revision < SceneManifest::kUnderWay) return rank;
  rank.followers = static_cast<std::size_t>(std::ranges::count_if(offers_, [&](const Offer& other) {
    return other.here && present_.contains(other.manifest.offered_by) &&
           other.manifest.revision >= SceneManifest::kUnderWay &&
           other.manifest.content_digest == manifest.content_digest &&
           ParametersOf(other.manifest) == ParametersOf(manifest);
  }));
  return rank;
}

void SceneOffers::OnScene(const SceneManifest& manifest) {
  const auto known = std::ranges::find_if(offers_, [&](const Offer& offer) {
    return offer.manifest.offered_by == manifest.offered_by;
  });
  if (known != offers_.end()) {
    *known = {manifest, true};
    return;
  }
  if (offers_.size() < kMost) {
    offers_.push_back({manifest, true});
    return;
  }
  const auto before = [this](const Offer& a, const Offer& b) {
    return RankOf(a) < RankOf(b);
  };
  const auto last = std::max_element(offers_.begin(), offers_.end(), before);
  if (const Offer offer{manifest, true}; RankOf(offer) < RankOf(*last)) *last = offer;
}

void SceneOffers::OnWithdrawn(PeerId peer) {
  if (!remembers_) {
    std::erase_if(offers_, [peer](const Offer& offer) {
      return offer.manifest.offered_by == peer;
    });
  }
  for (Offer& offer : offers_) {
    if (offer.manifest.offered_by == peer) offer.here = false;
  }
}

void SceneOffers::OnPresence(PeerId peer, bool here) {
  constexpr std::size_t kMostPresent = 256;
  if (!here) {
    present_.erase(peer);
  } else if (present_.size() < kMostPresent) {
    present_.insert(peer);
  }
  for (Offer& offer : offers_) {
    if (offer.manifest.offered_by == peer) offer.here = here;
  }
}

std::vector<SceneOffers::Offer>::const_iterator SceneOffers::First() const {
  const auto before = [this](const Offer& a, const Offer& b) {
    return RankOf(a) < RankOf(b);
  };
  const auto first = std::min_element(offers_.begin(), offers_.end(), before);
  return first == offers_.end() || first->here || remembers_ ? first : offers_.end();
}

const SceneManifest* SceneOffers::session() const {
  const auto first = First();
  return first == offers_.end() ? nullptr : &first->manifest;
}

std::vector<SceneManifest> SceneOffers::All() const {
  std::vector<SceneManifest> all;
  for (const Offer& offer : offers_) {
    if (offer.here) all.push_back(offer.manifest);
  }
  return all;
}

const SceneManifest* SceneOffers::From(PeerId peer) const {
  for (const Offer& offer : offers_) {
    if (offer.manifest.offered_by == peer) return &offer.manifest;
  }
  return nullptr;
}

}  // namespace tandem
