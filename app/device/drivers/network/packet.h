#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// The packets between Tandem and a device in another process or machine. docs/devices.md has their
/// layout, byte by byte; whoever writes the other end goes by that.
namespace tandem::driver::network {

inline constexpr std::uint8_t kProtocolVersion = 1;
inline constexpr std::size_t kHeaderBytes = 48;
inline constexpr std::size_t kCodeBytes = 32;
inline constexpr std::size_t kLongestBytes = 256;

/// The top bit is the direction, so that no packet can be sent back to its sender.
enum class Kind : std::uint8_t {
  kHello = 1,
  kState = 2,
  kDeviceEnds = 3,
  kWelcome = 129,
  kForce = 130,
  kHostEnds = 131
};

/// How long a packet of that kind is without its code; 0: there is no such kind.
std::size_t BytesOf(Kind kind);

struct Header {
  Kind kind = Kind::kHello;
  std::uint64_t device_session = 0;  // random, of the device's run
  std::uint64_t host_session = 0;    // as Tandem has said it in its welcome
  std::uint64_t sequence = 0;        // of the sender in this session, rising
  std::int64_t time_ns = 0;          // when it was sent, by the sender's clock
  std::int64_t echo_ns = 0;          // time_ns of the other end's packet that it follows from
};

/// What a device can, as TandemDeviceCapabilities has it.
struct Hello {
  std::uint32_t freedoms_in = 0;
  std::uint32_t freedoms_out = 0;
  double rate_hz = 0;
  double peak_force = 0, peak_moment = 0;
  double continuous_force = 0, continuous_moment = 0;
  double stiffness = 0, damping = 0;
  double rotation_stiffness = 0, rotation_damping = 0;
  std::array<double, 3> workspace_min{}, workspace_max{};
  std::array<char, 32> name{};

  bool operator==(const Hello&) const = default;
};

/// Where the handle is, as TandemDeviceState has it.
struct State {
  std::uint32_t valid = 0;
  std::uint32_t buttons = 0;
  std::array<double, 3> position{};
  std::array<double, 4> orientation{0, 0, 0, 1};
  std::array<double, 3> velocity{};
  std::array<double, 3> angular_velocity{};
};

/// What the motors are to give. It is void `expiry_us` after the state that it follows from was
/// sent, by the device's own clock.
struct Force {
  std::uint32_t expiry_us = 0;
  std::uint32_t reserved = 0;
  std::array<double, 3> force{};
  std::array<double, 3> moment{};
};

/// A packet in the making: header, body, code.
class PacketWriter {
 public:
  /// `keyed`: room is left for a code.
  PacketWriter(const Header& header, bool keyed);
  void Put(const Hello& hello);
  void Put(const State& state);
  void Put(const Force& force);
  std::span<const std::uint8_t> bytes() const { return {bytes_.data(), size_}; }
  /// What the code is over, and the code.
  std::span<const std::uint8_t> text() const { return {bytes_.data(), size_ - code_}; }
  std::span<std::uint8_t> code() { return {bytes_.data() + size_ - code_, code_}; }

 private:
  template <typename Number>
  void Append(Number number);
  template <typename Numbers>
  void AppendAll(const Numbers& numbers);

  std::array<std::uint8_t, kLongestBytes> bytes_{};
  std::size_t at_ = 0;
  std::size_t size_ = 0;
  std::size_t code_ = 0;
};

/// What is wrong with a packet's form.
enum class Form { kSound, kShort, kLong, kForeign, kVersion };

/// Reads the header of a packet whose length is what its kind has.
Form ReadHeader(std::span<const std::uint8_t> bytes, bool keyed, Header& header);
/// Reads what follows the header of a sound packet of that kind.
Hello ReadHello(std::span<const std::uint8_t> bytes);
State ReadState(std::span<const std::uint8_t> bytes);
Force ReadForce(std::span<const std::uint8_t> bytes);

/// All numbers are such that a simulation can go by them.
bool IsSound(const Hello& hello);
bool IsSound(const State& state);

}  // namespace tandem::driver::network
