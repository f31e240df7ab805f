#include "app/device/drivers/network/packet.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <type_traits>

#include "app/device/tandem_device.h"

namespace tandem::driver::network {
namespace {

constexpr std::array<std::uint8_t, 4> kMagic{'T', 'D', 'M', 'D'};
constexpr double kMostPosition = 100;  // m
constexpr double kMostVelocity = 100;  // m/s, rad/s
constexpr double kMostCan = 1e9;       // limit on capabilities
constexpr std::size_t kHelloBytes = 208;
constexpr std::size_t kStateBytes = 160;
constexpr std::size_t kForceBytes = 104;

template <typename Number>
using BitsOf =
    std::conditional_t<sizeof(Number) == 8, std::uint64_t,
                       std::conditional_t<sizeof(Number) == 4, std::uint32_t, std::uint16_t>>;

/// Takes numbers off a packet in turn, the lowest byte first.
class Reader {
 public:
  Reader(std::span<const std::uint8_t> bytes, std::size_t at) : bytes_(bytes), at_(at) {}
  template <typename Number>
  void Take(Number& number) {
    BitsOf<Number> bits = 0;
    for (std::size_t i = 0; i < sizeof(Number); ++i) {
      bits =
          static_cast<BitsOf<Number>>(bits | static_cast<BitsOf<Number>>(bytes_[at_++]) << 8 * i);
    }
    number = std::bit_cast<Number>(bits);
  }
  template <typename... Numbers>
  void TakeAll(Numbers&... numbers) {
    (Take(numbers), ...);
  }
  template <typename Number, std::size_t kCount>
  void Take(std::array<Number, kCount>& numbers) {
    for (Number& number : numbers) Take(number);
  }
  void Take(std::array<char, 32>& text) {
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), text.size(), text.begin());
    text.back() = '\0';
  }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_;
};

template <std::size_t kCount>
bool AreWithin(const std::array<double, kCount>& numbers, double most) {
  return std::ranges::all_of(numbers, [most](double x) {
    return std::abs(x) <= most;  // false for NaN
  });
}

}  // namespace

std::size_t BytesOf(Kind kind) {
  switch (kind) {
    case Kind::kHello:
      return kHelloBytes;
    case Kind::kState:
      return kStateBytes;
    case Kind::kForce:
      return kForceBytes;
    case Kind::kDeviceEnds:
    case Kind::kWelcome:
    case Kind::kHostEnds:
      return kHeaderBytes;
  }
  return 0;
}

template <typename Number>
void PacketWriter::Append(Number number) {
  const auto bits = std::bit_cast<BitsOf<Number>>(number);
  for (std::size_t i = 0; i < sizeof(Number); ++i) {
    bytes_[at_++] = static_cast<std::uint8_t>(bits >> 8 * i & 0xFF);
  }
}

template <typename Numbers>
void PacketWriter::AppendAll(const Numbers& numbers) {
  for (const auto number : numbers) Append(number);
}

PacketWriter::PacketWriter(const Header& header, bool keyed) {
  code_ = keyed ? kCodeBytes : 0;
  size_ = BytesOf(header.kind) + code_;
  for (const std::uint8_t byte : kMagic) bytes_[at_++] = byte;
  bytes_[at_++] = kProtocolVersion;
  bytes_[at_++] = static_cast<std::uint8_t>(header.kind);
  Append(static_cast<std::uint16_t>(size_));
  Append(header.device_session);
  Append(header.host_session);
  Append(header.sequence);
  Append(header.time_ns);
  Append(header.echo_ns);
}

void PacketWriter::Put(const Hello& hello) {
  Append(hello.freedoms_in);
  Append(hello.freedoms_out);
  AppendAll(std::array{hello.rate_hz, hello.peak_force, hello.peak_moment, hello.continuous_force,
                       hello.continuous_moment, hello.stiffness, hello.damping,
                       hello.rotation_stiffness, hello.rotation_damping});
  AppendAll(hello.workspace_min);
  AppendAll(hello.workspace_max);
  for (const char c : hello.name) bytes_[at_++] = static_cast<std::uint8_t>(c);
}

void PacketWriter::Put(const State& state) {
  Append(state.valid);
  Append(state.buttons);
  AppendAll(state.position);
  AppendAll(state.orientation);
  AppendAll(state.velocity);
  AppendAll(state.angular_velocity);
}

void PacketWriter::Put(const Force& force) {
  Append(force.expiry_us);
  Append(force.reserved);
  AppendAll(force.force);
  AppendAll(force.moment);
}

Form ReadHeader(std::span<const std::uint8_t> bytes, bool keyed, Header& header) {
  if (bytes.size() < kHeaderBytes) return Form::kShort;
  if (!std::equal(kMagic.begin(), kMagic.end(), bytes.begin())) return Form::kForeign;
  if (bytes[4] != kProtocolVersion) return Form::kVersion;
  header.kind = static_cast<Kind>(bytes[5]);
  const std::size_t wanted = BytesOf(header.kind) + (keyed ? kCodeBytes : 0);
  if (BytesOf(header.kind) == 0) return Form::kForeign;
  if (bytes.size() != wanted) return bytes.size() < wanted ? Form::kShort : Form::kLong;
  Reader reader(bytes, 6);
  std::uint16_t length = 0;
  reader.TakeAll(length, header.device_session, header.host_session, header.sequence,
                 header.time_ns, header.echo_ns);
  return length == wanted ? Form::kSound : Form::kForeign;
}

Hello ReadHello(std::span<const std::uint8_t> bytes) {
  Hello hello;
  Reader reader(bytes, kHeaderBytes);
  reader.TakeAll(hello.freedoms_in, hello.freedoms_out, hello.rate_hz, hello.peak_force,
                 hello.peak_moment, hello.continuous_force, hello.continuous_moment,
                 hello.stiffness, hello.damping, hello.rotation_stiffness, hello.rotation_damping);
  reader.TakeAll(hello.workspace_min, hello.workspace_max, hello.name);
  return hello;
}

State ReadState(std::span<const std::uint8_t> bytes) {
  State state;
  Reader reader(bytes, kHeaderBytes);
  reader.TakeAll(state.valid, state.buttons, state.position, state.orientation, state.velocity,
                 state.angular_velocity);
  return state;
}

Force ReadForce(std::span<const std::uint8_t> bytes) {
  Force force;
  Reader reader(bytes, kHeaderBytes);
  reader.TakeAll(force.expiry_us, force.reserved, force.force, force.moment);
  return force;
}

bool IsSound(const Hello& hello) {
  const std::array can{hello.rate_hz,
                       hello.peak_force,
                       hello.peak_moment,
                       hello.continuous_force,
                       hello.stiffness,
                       hello.continuous_moment,
                       hello.rotation_stiffness,
                       hello.damping,
                       hello.rotation_damping};
  return hello.freedoms_in <= 6 && hello.freedoms_out <= 6 && AreWithin(can, kMostCan) &&
         *std::ranges::min_element(can) >= 0 && AreWithin(hello.workspace_min, kMostPosition) &&
         AreWithin(hello.workspace_max, kMostPosition);
}

bool IsSound(const State& state) {
  double square = 0;
  for (const double x : state.orientation) square += x * x;
  const bool turns = (state.valid & TANDEM_HAS_VELOCITY) != 0;
  return (state.valid & TANDEM_HAS_POSE) != 0 && AreWithin(state.position, kMostPosition) &&
         std::abs(square - 1) < 0.01 &&
         (!turns || (AreWithin(state.velocity, kMostVelocity) &&
                     AreWithin(state.angular_velocity, kMostVelocity)));
}

}  // namespace tandem::driver::network
