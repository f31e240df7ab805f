#pragma once

#include <array>
#include <ctime>
#include <string>

#include "collab/messages.h"

namespace tandem {

/// The subject of a member's certificate, as DDS Security writes it. The id is part of it: a
/// certificate is one peer's, whatever its name.
std::string SubjectOf(const std::string& name, PeerId peer);

/// What all members of a secured session must keep to (DDS Security §9.4.1.2): nobody without a
/// certificate, discovery encrypted, all packets signed so that each receiver knows which member
/// sent them, all samples encrypted with keys that only matched readers get.
std::string GovernanceXml();

/// What one member may do (§9.4.1.3), and nothing else. A peer publishes in its own partitions
/// peer.<id>, view.<id> and scene.<id>, and its presence in peer.<id>.<name>; a viewer publishes
/// its presence in viewer.<id>.<name>, and of pose topics it reads view/1 only. Room is left for
/// what comes, so that keys need not change: review/* (notes and cameras) is everybody's, file/*
/// (files of scenes) the peers'. No program of this protocol reads them.
std::string PermissionsXml(const std::string& name, PeerId peer, Role role, std::time_t from,
                           std::time_t until);

/// What a relay may do among those who look on behind it: say what each peer that it shows says.
/// Nothing there is worth having for a peer, so these are of a session of their own.
std::string RelayPermissionsXml(const std::string& name, PeerId peer, std::time_t from,
                                std::time_t until);

/// The topics of a controller's command interface, and who says what in which partition.
inline constexpr std::array<const char*, 5> kControlTopics{"request/1", "answer/1", "goal/1",
                                                           "scene/1", "snapshot/1"};
inline constexpr const char* kHostPartition = "host";
inline constexpr const char* kControllerPartition = "controller";

/// What a controller, or else a host of it, may do in the domain of its command interface.
std::string ControlPermissionsXml(const std::string& name, PeerId id, bool controller,
                                  std::time_t from, std::time_t until);

}  // namespace tandem
