#include "collab/recording/recording.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include <nlohmann/json.hpp>

#include "collab/coupling_limits.h"
#include "collab/recording/frame_code.h"
#include "collab/recording/recorder.h"
#include "engine/base/json_text.h"

namespace tandem {
namespace {

using nlohmann::ordered_json;

constexpr std::uint32_t kMaxHeader = 1U << 20U;
constexpr std::uint32_t kMaxFrame = 1U << 26U;

static_assert(std::endian::native == std::endian::little);

// Takes numbers from a frame's bytes; beyond their end it gives zeros and says so.
class Decoder {
 public:
  Decoder(const char* data, std::size_t size) : data_(data), end_(data + size) {}
  template <typename T>
  void operator()(T& value) {
    value = T{};
    if (static_cast<std::size_t>(end_ - data_) < sizeof value) {
      sound_ = false;
      data_ = end_;
      return;
    }
    std::memcpy(&value, data_, sizeof value);
    data_ += sizeof value;
  }
  bool done() const { return data_ == end_; }
  bool sound() const { return sound_; }

 private:
  const char* data_;
  const char* end_;
  bool sound_ = true;
};

template <typename T>
bool Read(std::ifstream& stream, T& value) {
  return static_cast<bool>(stream.read(reinterpret_cast<char*>(&value), sizeof value));
}

template <typename T>
void AddPart(Decoder& decoder, std::vector<T>& parts) {
  CodeFields(decoder, parts.emplace_back());
}

std::optional<RecordedFrame> Decode(const std::vector<char>& bytes) {
  Decoder decoder(bytes.data(), bytes.size());
  RecordedFrame frame;
  while (!decoder.done()) {
    FramePart part{};
    decoder(part);
    switch (part) {
      case FramePart::kBegin:
        decoder(frame.now_ns);
        decoder(frame.capacity);
        break;
      case FramePart::kMembership:
        AddPart(decoder, frame.changes);
        break;
      case FramePart::kEvent:
        AddPart(decoder, frame.events);
        break;
      case FramePart::kState:
        AddPart(decoder, frame.states);
        break;
      case FramePart::kLinks:
        AddPart(decoder, frame.links);
        break;
      case FramePart::kCommand:
        AddPart(decoder, frame.commands);
        break;
      case FramePart::kDevice:
        CodeFields(decoder, frame.device);
        break;
      case FramePart::kEnd:
        decoder(frame.state_hash);
        break;
      default:
        return std::nullopt;
    }
  }
  if (!decoder.sound()) return std::nullopt;
  return frame;
}

ordered_json LimitsOf(const CouplingLimits& limits) {
  ordered_json json;
  for (const LimitName& limit : kLimitNames) json[std::string(limit.name)] = limits.*limit.value;
  return json;
}

/// A gain that a device bears, by its name in the header.
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
// kBegin and kEnd with what they bring
constexpr std::size_t kLeastFrame = 1 + 16 + 1 + 8;

template <typename T>
T At(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

/// Whether a frame as we write it begins here.
bool IsFrame(const char* bytes, std::size_t size) {
  if (size < kFrameHead + kLeastFrame) return false;
  const auto length = At<std::uint32_t>(bytes);
  if (length < kLeastFrame || length > size - kFrameHead) return false;
  const char* content = bytes + kFrameHead;
  return At<FramePart>(content) == FramePart::kBegin &&
         At<FramePart>(content + length - 9) == FramePart::kEnd &&
         Crc32(content, length) == At<std::uint32_t>(bytes + 4);
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
                          {"contact", header.contact},
                          {"law", header.law},
                          {"law_limits", LimitsOf(header.limits)},
                          {"gate", header.peer.coupling.gate},
                          {"peer", header.peer.id},
                          {"held_object", header.peer.held_object},
                          {"grasp", {q[0], q[1], q[2], q[3], X_BD.p[0], X_BD.p[1], X_BD.p[2]}},
                          {"settle_ns", header.peer.settle_ns},
                          {"wait_for", header.peer.wait_for},
                          {"capacity", header.peer.capacity},
                          {"look_price", header.peer.look_price}};
  // a device that bears all has none of these
  for (const BorneGain& gain : kBorneGains) {
    const double most = header.device.*gain.value;
    if (std::isfinite(most)) json["device"][gain.name] = most;
  }
  return JsonText(json);
}

Result<RecordingHeader> ParseHeader(const std::string& text) {
  try {
    const ordered_json json = ordered_json::parse(text);
    if (json.at("protocol") != kProtocol) {
      return Error{"recorded with protocol " + JsonText(json.at("protocol")) + ", this program's is " +
                   std::to_string(kProtocol)};
    }
    RecordingHeader header;
    header.program = json.at("program");
    header.name = json.at("name");
    header.scene = json.at("scene");
    header.scene_hash = json.at("scene_hash");
    header.parameters.voxel_size = json.at("voxel_size");
    header.parameters.contact =
        json.at("contact_model") == 0 ? ContactModel::kPlain : ContactModel::kRefined;
    header.parameters.force_layer = json.at("force_layer");
    header.parameters.friction = json.at("friction");
    header.peer.own_only = json.at("own_only");
    header.contact = json.at("contact");
    header.law = json.at("law");
    for (const LimitName& limit : kLimitNames) {
      // a recording of before a limit has none of it
      header.limits.*limit.value =
          json.at("law_limits").value(std::string(limit.name), header.limits.*limit.value);
    }
    header.peer.coupling.gate = json.at("gate");
    header.peer.id = json.at("peer");
    header.peer.held_object = json.at("held_object");
    const std::array<double, 7> grasp = json.at("grasp");
    for (int i = 0; i < 4; ++i) header.peer.X_BD.q.coeffs()[i] = grasp[static_cast<std::size_t>(i)];
    for (int i = 0; i < 3; ++i) header.peer.X_BD.p[i] = grasp[static_cast<std::size_t>(4 + i)];
    header.peer.settle_ns = json.at("settle_ns");
    header.peer.wait_for = json.at("wait_for");
    header.peer.capacity = json.at("capacity");
    header.peer.look_price = json.at("look_price");
    for (const BorneGain& gain : kBorneGains) {
      if (!json.contains("device")) break;
      header.device.*gain.value = json.at("device").value(gain.name, DeviceCapabilities::kAny);
    }
    return header;
  } catch (const ordered_json::exception& bad) {
    return Error{std::string("its header cannot be read: ") + bad.what()};
  }
}

Result<RecordingReader> RecordingReader::Open(const std::filesystem::path& file) {
  RecordingReader reader;
  reader.stream_.open(file, std::ios::binary);
  if (!reader.stream_) {
    std::error_code unknown;
    const bool there = std::filesystem::exists(file, unknown) || unknown;
    return Error{file.string() + (there ? ": cannot be opened" : ": there is no such file")};
  }
  std::string magic(kRecordingMagic.size(), '\0');
  std::uint32_t length = 0;
  if (!reader.stream_.read(magic.data(), static_cast<std::streamsize>(magic.size())) ||
      (magic != kRecordingMagic && magic != kFirstRecordingMagic) ||
      !Read(reader.stream_, length) || length > kMaxHeader) {
    return Error{file.string() + ": is not a recording"};
  }
  std::string text(length, '\0');
  if (!reader.stream_.read(text.data(), length)) {
    return Error{file.string() + ": ends within its header"};
  }
  Result<RecordingHeader> header = ParseHeader(text);
  if (!header) return Error{file.string() + ": " + header.error().what};
  reader.header_ = *std::move(header);
  reader.names_[reader.header_.peer.id] = reader.header_.name;
  reader.at_ = static_cast<std::uintmax_t>(reader.stream_.tellg());
  std::error_code no_file;  // a pipe has no size, and is not damaged for that
  const std::uintmax_t size = std::filesystem::file_size(file, no_file);
  reader.size_ = no_file ? 0 : size;
  return reader;
}

std::nullopt_t RecordingReader::Stop(Fault fault) {
  fault_ = fault;
  unread_bytes_ = size_ - std::min(size_, at_);
  return std::nullopt;
}

// a frame's length may be what is damaged: then the file only seems to end within the frame
bool RecordingReader::GoesOn() {
  stream_.clear();
  stream_.seekg(static_cast<std::streamoff>(at_));
  bytes_.resize(size_ - std::min(size_, at_));
  stream_.read(bytes_.data(), static_cast<std::streamsize>(bytes_.size()));
  const auto got = static_cast<std::size_t>(stream_.gcount());
  for (std::size_t i = 1; i < got; ++i) {
    if (IsFrame(bytes_.data() + i, got - i)) return true;
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
  Decoder decoder(bytes_.data(), bytes_.size());
  FramePart part{};
  PeerId peer = 0;
  std::array<char, kNameBytes> name{};
  decoder(part);
  decoder(peer);
  decoder(name);
  if (!decoder.sound() || !decoder.done()) return false;
  names_[peer] = std::string(name.data(), strnlen(name.data(), name.size()));
  return true;
}

std::optional<RecordedFrame> RecordingReader::Next() {
  while (fault_ == Fault::kNone) {
    if (!ReadContent()) return std::nullopt;
    if (bytes_.front() == static_cast<char>(FramePart::kName)) {
      if (!TakeName()) return Stop(Fault::kDamaged);
    } else {
      std::optional<RecordedFrame> frame = Decode(bytes_);
      if (!frame) return Stop(Fault::kDamaged);
      at_ += kFrameHead + bytes_.size();
      return frame;
    }
    at_ += kFrameHead + bytes_.size();
  }
  return std::nullopt;
}

bool RecordingReader::ReadContent() {
  std::uint32_t length = 0;
  std::uint32_t crc = 0;
  const auto stop = [this](Fault fault) {
    static_cast<void>(Stop(fault));
    return false;
  };
  if (!Read(stream_, length)) return stream_.gcount() > 0 && stop(Fault::kTorn);
  if (!Read(stream_, crc)) return stop(Fault::kTorn);
  if (length < kLeastFrame || length > kMaxFrame) return stop(Fault::kDamaged);
  bytes_.resize(length);
  if (!stream_.read(bytes_.data(), length)) return stop(GoesOn() ? Fault::kDamaged : Fault::kTorn);
  return Crc32(bytes_.data(), length) == crc || stop(Fault::kDamaged);
}

}  // namespace tandem
