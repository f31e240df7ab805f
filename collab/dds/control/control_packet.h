#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tandem_control.h"  // idlc's

namespace tandem {

/// The messages between hosts and a controller, by their direction.
enum class ControlTopic : std::uint8_t {
  kRequest,  // from a host, as kGoal
  kAnswer,   // to a host, as the two below
  kGoal,
  kScene,
  kSnapshot
};

/// Returns a message as a packet: eight bytes that name the topic, then the type of
/// idl/tandem_control.idl as DDS writes it (XCDR2). Empty: the message has too many parts.
std::vector<char> PacketOf(const tandem_control_Request& message);
std::vector<char> PacketOf(const tandem_control_Answer& message);
std::vector<char> PacketOf(const tandem_control_Goal& message);
std::vector<char> PacketOf(const tandem_control_Scene& message);
std::vector<char> PacketOf(const tandem_control_Snapshot& message);

/// Returns the topic that a packet names; nothing: it is no packet of this interface.
std::optional<ControlTopic> TopicOf(std::span<const char> packet);

/// Reads a packet into an empty message, whose lists FreeMessage() frees. False: the packet is
/// damaged, and the message stays empty. The packet's bytes are changed in place.
bool ReadPacket(std::span<char> packet, ControlTopic topic, void* message);
void FreeMessage(ControlTopic topic, void* message);

/// Calls use(message) with the message of a packet. `T`: the topic's type. False: the packet is
/// damaged, and `use` is not called.
template <typename T, typename Use>
bool UsePacket(std::span<char> packet, ControlTopic topic, Use use) {
  T message{};
  const bool sound = ReadPacket(packet, topic, &message);
  if (sound) use(message);
  FreeMessage(topic, &message);
  return sound;
}

}  // namespace tandem
