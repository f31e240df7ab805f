#include "collab/recording/recording.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include <nlohmann/json.hpp>

#include "collab/coupling/coupling_limits.h"
#include "collab/recording/frame_code.h"
#include "collab/recording/recorder.h"
#include "engine/base/text/hex.h"
#include "engine/base/text/json_reader.h"
#include "engine/base/text/json_text.h"
#include "engine/contact/pair/friction.h"

namespace tandem {
namespace {

using nlohmann::ordered_json;

constexpr std::uint32_t kMaxHeader = 1U << 20U;
constexpr std::uint32_t kMaxFrame = 1U << 24U;  // size of the recorder's ring: no frame is longer
constexpr std::size_t kBlock = 1U << 18U;
constexpr std::size_t kLongestName = 256;   // bytes
constexpr std::size_t kLongestPath = 4096;  // bytes
constexpr double kFarthestGrasp = 1e3;      // m; the bound for samples of peers

static_assert(std::endian::native == std::endian::little);

ordered_json LimitsOf(const CouplingLimits& limits) {
  ordered_json json;
  for (const LimitName& limit : kLimitNames) json[std::string(limit.name)] = limits.*limit.value;
  return json;
}

/// A gain that a device bears, under its name in the header.
struct BorneGain {
  const char* name;
  double DeviceCapabilities::*value;
};
constexpr std::array<BorneGain, 4> kBorneGains{
    {{"stiffness", &DeviceCapabilities::stiffness},
     {"damping", &DeviceCapabilities::damping},
     {"rotation_stiffness", &DeviceCapabilities::rotation_stiffness},
     {"rotation_damping", &DeviceCapabilities::rotation_damping}}};

constexpr std::size_t kFrameHead = 8;  // length and CRC
// kBegin and kEnd with their fields
constexpr std::size_t kLeastFrame = 1 + 16 + 1 + 8;

template <typename T>
T At(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

/// Returns whether a whole frame begins here. Takes the number of summed bytes from `budget`.
bool IsFrame(const char* bytes, std::size_t size, std::size_t& budget) {
  if (size < kFrameHead + kLeastFrame) return false;
  const auto length = At<std::uint32_t>(bytes);
  if (length < kLeastFrame || length > size - kFrameHead) return false;
  const char* content = bytes + kFrameHead;
  if (At<FramePart>(content) != FramePart::kBegin ||
      At<FramePart>(content + length - 9) != FramePart::kEnd) {
    return false;
  }
  budget -= std::min<std::size_t>(budget, length);
  return Crc32(content, length) == At<std::uint32_t>(bytes + 4);
}

std::array<std::uint32_t, 256> CrcTable() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    std::uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
    table[i] = crc;
  }
  return table;
}

Quat GraspTurn(const std::vector<JsonNode>& grasp) {
  Quat q;
  for (int i = 0; i < 4; ++i) q.coeffs()[i] = grasp[static_cast<std::size_t>(i)].Number();
  if (std::abs(q.norm() - 1.0) < 1e-3) return q;
  grasp[0].Expected("a rotation [x, y, z, w] of length 1");
  return Quat::Identity();
}

ForceParameters ParametersIn(const JsonNode& root) {
  ForceParameters parameters;
  parameters.voxel_size = root["voxel_size"].NumberAbove(0);
  parameters.contact =
      root["contact_model"].WholeNumber(0, 1) == 0 ? ContactModel::kPlain : ContactModel::kRefined;
  parameters.force_layer = root["force_layer"].WholeNumber(0, WidestRange(8) - kWarningQueues);
  if (const std::string fault = LayerFault(parameters.contact, parameters.force_layer);
      !fault.empty()) {
    root["force_layer"].Fault(fault);
  }
  parameters.friction = root["friction"].NumberBetween(0, kMostFriction);
  return parameters;
}

PeerOptions PeerIn(const JsonNode& root) {
  constexpr int kMostBodies = 1 << 16;
  constexpr std::uint64_t kLongestSettlingNs = 1'000'000'000'000;
  PeerOptions peer;
  peer.own_only = root["own_only"].TrueOrFalse();
  peer.experiments.contact = root["contact"].TrueOrFalse();
  peer.experiments.energy_gate = root["gate"].TrueOrFalse();
  peer.id = root["peer"].Unsigned();
  peer.held_object = root["held_object"].WholeNumber(-1, kMostBodies);
  const std::vector<JsonNode> grasp = root["grasp"].Items();
  if (grasp.size() == 7) {
    peer.X_BD.q = GraspTurn(grasp);
    for (std::size_t i = 0; i < 3; ++i) {
      peer.X_BD.p[static_cast<int>(i)] =
          grasp[4 + i].NumberBetween(-kFarthestGrasp, kFarthestGrasp);
    }
  } else {
    root["grasp"].Expected("seven numbers");
  }
  peer.settle_ns = static_cast<std::int64_t>(root["settle_ns"].Unsigned(kLongestSettlingNs));
  peer.wait_for = static_cast<std::size_t>(root["wait_for"].WholeNumber(0, kMaxPeers));
  peer.capacity = root["capacity"].NumberFrom(0);
  peer.query_price = root["look_price"].NumberFrom(0);
  return peer;
}

RecordingHeader HeaderIn(const JsonNode& root) {
  RecordingHeader header;
  header.program = root["program"].PlainText(kNameBytes);
  header.name = root["name"].PlainText(kLongestName);
  header.scene = root["scene"].PlainText(kLongestPath);
  header.scene_hash = root["scene_hash"].Unsigned();
  if (root.Has("scene_digest")) {
    Sha256& digest = header.scene_digest.emplace();
    if (!FromHexOfBytes(root["scene_digest"].PlainText(2 * digest.size()), digest)) {
      root["scene_digest"].Expected("64 hexadecimal digits");
    }
  }
  header.parameters = ParametersIn(root);
  header.law = root["law"].PlainText(kNameBytes);
  const JsonNode limits = root["law_limits"];
  for (const LimitName& limit : kLimitNames) {
    // a recording older than a limit lacks it
    if (limits.Has(limit.name)) header.limits.*limit.value = limits[limit.name].NumberFrom(0);
  }
  header.peer = PeerIn(root);
  for (const BorneGain& gain : kBorneGains) {
    const JsonNode device = root["device"];
    if (!root.Has("device") || !device.Has(gain.name)) continue;
    header.device.*gain.value = device[gain.name].NumberFrom(0);
  }
  if (root.Has("device_scale")) header.device_scale = root["device_scale"].NumberFrom(1e-3);
  return header;
}

}  // namespace

std::uint32_t Crc32(const void* data, std::size_t size, std::uint32_t before) {
  static const std::array<std::uint32_t, 256> table = CrcTable();
  std::uint32_t crc = ~before;
  const auto* bytes = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < size; ++i) crc = (crc >> 8U) ^ table[(crc ^ bytes[i]) & 0xFFU];
  return ~crc;
}

std::string AsText(const RecordingHeader& header) {
  const Pose& X_BD = header.peer.X_BD;
  const auto& q = X_BD.q.coeffs();
  ordered_json json{{"program", header.program},
                    {"protocol", kProtocol},
                    {"name", header.name},
                    {"scene", header.scene},
                    {"scene_hash", header.scene_hash},
                    {"voxel_size", header.parameters.voxel_size},
                    {"contact_model", static_cast<int>(header.parameters.contact)},
                    {"force_layer", header.parameters.force_layer},
                    {"friction", header.parameters.friction},
                    {"own_only", header.peer.own_only},
                    {"contact", header.peer.experiments.contact},
                    {"law", header.law},
                    {"law_limits", LimitsOf(header.limits)},
                    {"gate", header.peer.experiments.energy_gate},
                    {"peer", header.peer.id},
                    {"held_object", header.peer.held_object},
                    {"grasp", {q[0], q[1], q[2], q[3], X_BD.p[0], X_BD.p[1], X_BD.p[2]}},
                    {"settle_ns", header.peer.settle_ns},
                    {"wait_for", header.peer.wait_for},
                    {"capacity", header.peer.capacity},
                    {"look_price", header.peer.query_price}};
  if (header.scene_digest) json["scene_digest"] = HexOfBytes(*header.scene_digest);
  // a device that bears every gain has none of these
  for (const BorneGain& gain : kBorneGains) {
    const double most = header.device.*gain.value;
    if (std::isfinite(most)) json["device"][gain.name] = most;
  }
  if (header.device_scale != 1) json["device_scale"] = header.device_scale;
  return JsonText(json);
}

Result<RecordingHeader> ParseHeader(const std::string& text) {
  const Result<JsonFile> json = JsonFile::Parse(text, "its header");
  if (!json) return json.error();
  const JsonNode root = json->root();
  // protocol 6 adds digests to what peers say; a frame has the same inputs as by protocol 5
  const std::string protocol = root.IsObject() ? root["protocol"].Compact() : "";
  if (root.IsObject() && protocol != std::to_string(kProtocol) && protocol != "5") {
    return Error{"recorded with protocol " + PlainLine(protocol, 20) + ", this program's is " +
                 std::to_string(kProtocol)};
  }
  RecordingHeader header = HeaderIn(root);
  if (json->fault()) return *json->fault();
  return header;
}

Result<RecordingReader> RecordingReader::Open(const std::filesystem::path& file) {
  Result<RegularFile> opened = RegularFile::Open(file);
  if (!opened) return opened.error();
  RecordingReader reader(*std::move(opened));
  const std::string named = PlainLine(file.native());
  std::string magic(kRecordingMagic.size(), '\0');
  std::array<char, sizeof(std::uint32_t)> length{};
  if (reader.Take(magic) != magic.size() ||
      (magic != kRecordingMagic && magic != kFirstRecordingMagic) ||
      reader.Take(length) != length.size() || At<std::uint32_t>(length.data()) > kMaxHeader) {
    return Error{named + ": is not a recording"};
  }
  std::string text(At<std::uint32_t>(length.data()), '\0');
  if (reader.Take(text) != text.size()) return Error{named + ": ends within its header"};
  Result<RecordingHeader> header = ParseHeader(text);
  if (!header) return Error{named + ": " + header.error().what};
  reader.header_ = *std::move(header);
  reader.names_[reader.header_.peer.id] = reader.header_.name;
  reader.at_ = magic.size() + length.size() + text.size();
  return reader;
}

std::size_t RecordingReader::Take(std::span<char> bytes) {
  std::size_t got = 0;
  while (got < bytes.size()) {
    if (taken_ == block_.size()) {
      block_.resize(kBlock);
      block_.resize(file_.Read(read_, block_));
      read_ += block_.size();
      taken_ = 0;
      if (block_.empty()) break;
    }
    const std::size_t some = std::min(bytes.size() - got, block_.size() - taken_);
    std::copy_n(block_.data() + taken_, some, bytes.data() + got);
    taken_ += some;
    got += some;
  }
  return got;
}

std::nullopt_t RecordingReader::Stop(Fault fault) {
  fault_ = fault;
  unread_bytes_ = file_.size() - std::min(file_.size(), at_);
  return std::nullopt;
}

// A damaged length makes the file seem to end within the frame, so the rest, shorter than the
// longest frame, is searched for a whole one. A file made to be summed for hours counts as damaged.
bool RecordingReader::GoesOn() {
  constexpr std::size_t kMostSummed = 4 * std::size_t{kMaxFrame};
  std::size_t budget = kMostSummed;
  bytes_.resize(
      std::min<std::uintmax_t>(file_.size() - std::min(file_.size(), at_), kFrameHead + kMaxFrame));
  const std::size_t got = file_.Read(at_, bytes_);
  for (std::size_t i = 1; i < got; ++i) {
    if (budget == 0 || IsFrame(bytes_.data() + i, got - i, budget)) return true;
  }
  return false;
}

std::map<PeerId, std::string> NamesIn(const std::filesystem::path& file) {
  Result<RecordingReader> reader = RecordingReader::Open(file);
  if (!reader) return {};
  while (reader->Next()) {
  }
  return reader->names();
}

bool RecordingReader::TakeName() {
  constexpr std::size_t kMostNames = 4096;
  constexpr std::size_t kText = 1 + sizeof(PeerId);
  if (bytes_.size() != kText + kNameBytes || names_.size() >= kMostNames) return false;
  const char* text = bytes_.data() + kText;
  names_[At<PeerId>(bytes_.data() + 1)] = PlainLine({text, strnlen(text, kNameBytes)}, kNameBytes);
  return true;
}

std::optional<RecordedFrame> RecordingReader::Next() {
  while (fault_ == Fault::kNone) {
    if (!ReadContent()) return std::nullopt;
    if (bytes_.front() == static_cast<char>(FramePart::kName)) {
      if (!TakeName()) return Stop(Fault::kDamaged);
    } else {
      std::optional<RecordedFrame> frame = DecodeFrame(bytes_);
      if (!frame) return Stop(Fault::kDamaged);
      at_ += kFrameHead + bytes_.size();
      return frame;
    }
    at_ += kFrameHead + bytes_.size();
  }
  return std::nullopt;
}

bool RecordingReader::ReadContent() {
  std::array<char, kFrameHead> head{};
  const auto stop = [this](Fault fault) {
    static_cast<void>(Stop(fault));
    return false;
  };
  const std::size_t got = Take(head);
  if (got < head.size()) return got > 0 && stop(Fault::kTorn);
  const auto length = At<std::uint32_t>(head.data());
  if (length < kLeastFrame || length > kMaxFrame) return stop(Fault::kDamaged);
  bytes_.resize(length);
  if (Take(bytes_) != length) return stop(GoesOn() ? Fault::kDamaged : Fault::kTorn);
  return Crc32(bytes_.data(), length) == At<std::uint32_t>(head.data() + 4) ||
         stop(Fault::kDamaged);
}

}  // namespace tandem
