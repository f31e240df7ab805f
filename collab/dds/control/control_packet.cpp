#include "collab/dds/control/control_packet.h"

#include <array>
#include <cstring>
#include <limits>

#include <dds/dds.h>
#undef restrict
#include <dds/ddsi/ddsi_cdrstream.h>

namespace tandem {

namespace {

constexpr std::uint32_t kXcdr2 = 2;  // encoding version
constexpr std::array<char, 3> kPacketMark{'T', 'C', '1'};
constexpr std::uint32_t kHead = 8;  // bytes; a multiple of the greatest alignment
constexpr std::uint32_t kFirstRoom = 4096;

const std::uint32_t* LayoutOf(ControlTopic topic) {
  switch (topic) {
    case ControlTopic::kRequest:
      return tandem_control_Request_desc.m_ops;
    case ControlTopic::kAnswer:
      return tandem_control_Answer_desc.m_ops;
    case ControlTopic::kGoal:
      return tandem_control_Goal_desc.m_ops;
    case ControlTopic::kScene:
      return tandem_control_Scene_desc.m_ops;
    case ControlTopic::kSnapshot:
      break;
  }
  return tandem_control_Snapshot_desc.m_ops;
}

std::vector<char> Packet(ControlTopic topic, const void* message) {
  dds_ostream_t stream{};
  dds_ostream_init(&stream, kFirstRoom, kXcdr2);
  std::memset(stream.m_buffer, 0, kHead);
  std::memcpy(stream.m_buffer, kPacketMark.data(), kPacketMark.size());
  stream.m_buffer[kPacketMark.size()] = static_cast<unsigned char>(topic);
  stream.m_index = kHead;
  std::vector<char> packet;
  if (dds_stream_write(&stream, static_cast<const char*>(message), LayoutOf(topic)) != nullptr) {
    const char* first = reinterpret_cast<const char*>(stream.m_buffer);
    packet.assign(first, first + stream.m_index);
  }
  dds_ostream_fini(&stream);
  return packet;
}

}  // namespace

std::vector<char> PacketOf(const tandem_control_Request& message) {
  return Packet(ControlTopic::kRequest, &message);
}
std::vector<char> PacketOf(const tandem_control_Answer& message) {
  return Packet(ControlTopic::kAnswer, &message);
}
std::vector<char> PacketOf(const tandem_control_Goal& message) {
  return Packet(ControlTopic::kGoal, &message);
}
std::vector<char> PacketOf(const tandem_control_Scene& message) {
  return Packet(ControlTopic::kScene, &message);
}
std::vector<char> PacketOf(const tandem_control_Snapshot& message) {
  return Packet(ControlTopic::kSnapshot, &message);
}

std::optional<ControlTopic> TopicOf(std::span<const char> packet) {
  if (packet.size() < kHead ||
      std::memcmp(packet.data(), kPacketMark.data(), kPacketMark.size()) != 0) {
    return std::nullopt;
  }
  const auto topic = static_cast<std::uint8_t>(packet[kPacketMark.size()]);
  if (topic > static_cast<std::uint8_t>(ControlTopic::kSnapshot)) return std::nullopt;
  return static_cast<ControlTopic>(topic);
}

bool ReadPacket(std::span<char> packet, ControlTopic topic, void* message) {
  if (TopicOf(packet) != topic || packet.size() > std::numeric_limits<std::uint32_t>::max()) {
    return false;
  }
  // the library checks lengths, counts and enumerated values, and reads what it has checked
  std::uint32_t end = kHead;
  const auto size = static_cast<std::uint32_t>(packet.size());
  if (dds_stream_normalize_data(packet.data(), &end, size, false, kXcdr2, LayoutOf(topic)) ==
      nullptr) {
    return false;
  }
  dds_istream_t stream{};
  dds_istream_init(&stream, size, packet.data(), kXcdr2);
  stream.m_index = kHead;
  dds_stream_read(&stream, static_cast<char*>(message), LayoutOf(topic));
  return true;
}

void FreeMessage(ControlTopic topic, void* message) {
  dds_stream_free_sample(message, LayoutOf(topic));
}

}  // namespace tandem
