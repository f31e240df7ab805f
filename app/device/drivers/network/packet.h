#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// The packets between Tandem and a device in another process or machine. docs/devices.md describes
/// their layout byte by byte for authors of the other end.
namespace tandem::driver::network {

inline constexpr std::uint8_t kProtocolVersion = 1;
inline constexpr std::size_t kHeaderBytes = 48;
inline constexpr std::size_t kCodeBytes = 32;
inline constexpr std::size_t kLongestBytes = 256;

/// The kind of a packet. The top bit is the direction, so that no packet can be sent back to its
/// sender.
enum class Kind : std::uint8_t {
  kHello = 1,
  kState = 2,
  kDeviceEnds = 3,
  kWelcome = 129,
  kForce = 130,
  kHostEnds = 131
};

/// Returns the length of a packet of that kind without its HMAC; 0: there is no such kind.
std::size_t BytesOf(Kind kind);

struct Header {
  Kind kind = Kind::kHello;
  std::uint64_t device_session = 0;  // random number of the device's run
  std::uint64_t host_session = 0;    // number from Tandem's welcome
  std::uint64_t sequence = 0;        // sender's count in this session, rising
  std::int64_t time_ns = 0;          // sending time, sender's clock
  std::int64_t echo_ns = 0;          // time_ns of the other end's packet that it follows from
};

/// The capabilities of a device, as in TandemDeviceCapabilities.
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

/// The state of the handle, as in TandemDeviceState.
struct State {
  std::uint32_t valid = 0;
  std::uint32_t buttons = 0;
  std::array<double, 3> position{};
  std::array<double, 4> orientation{0, 0, 0, 1};
  std::array<double, 3> velocity{};
  std::array<double, 3> angular_velocity{};
};

/// The wrench for the motors. It is void `expiry_us` after the state that it follows from was sent,
/// by the device's own clock.
struct Force {
  std::uint32_t expiry_us = 0;
  std::uint32_t reserved = 0;
  std::array<double, 3> force{};
  std::array<double, 3> moment{};
};

/// Builds a packet: header, body, code.
class PacketWriter {
 public:
  /// `keyed`: reserves room for a code.
  PacketWriter(const Header& header, bool keyed);
  void Put(const Hello& hello);
  void Put(const State& state);
  void Put(const Force& force);
  std::span<const std::uint8_t> bytes() const { return {bytes_.data(), size_}; }
  /// Return the bytes that the code covers, and the code.
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

/// The result of a check of a packet's form.
enum class Form { kSound, kShort, kLong, kForeign, kVersion };

/// Reads the header of a packet and checks that its length fits its kind.
Form ReadHeader(std::span<const std::uint8_t> bytes, bool keyed, Header& header);
/// Read the body of a sound packet of that kind.
Hello ReadHello(std::span<const std::uint8_t> bytes);
State ReadState(std::span<const std::uint8_t> bytes);
Force ReadForce(std::span<const std::uint8_t> bytes);

/// Return whether all values are in the ranges that a simulation can use.
bool IsSound(const Hello& hello);
bool IsSound(const State& state);

}  // namespace tandem::driver::network
