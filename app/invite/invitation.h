#pragma once

#include <array>
#include <cstdint>
#include <ctime>
#include <string>
#include <string_view>
#include <vector>

#include "collab/messages.h"
#include "engine/base/result.h"

namespace tandem {

using Secret128 = std::array<std::uint8_t, 16>;

/// What a line has that says how to enrol in a secured session: once, and until a moment.
struct EnrolmentTerms {
  std::uint16_t port = 0;  // TCP, at each of the invitation's hosts
  std::time_t until = 0;
  Secret128 secret{};       // whoever shows that it has it is the one who was invited
  Secret128 certificate{};  // first half of the SHA-256 of the listener's certificate

  friend bool operator==(const EnrolmentTerms&, const EnrolmentTerms&) = default;
};

/// A scene as far as somebody can find it on the own machine.
struct InvitedScene {
  static constexpr std::size_t kLongestFile = 100;  // bytes

  std::uint64_t digest = 0;  // of its content; 0: no scene is told
  std::uint32_t bodies = 0;
  std::string file;  // name, without its folder

  friend bool operator==(const InvitedScene&, const InvitedScene&) = default;
};

/// A line that says how to take part in a session, with nothing else:
///
///     tandem://HOST[:PORT],…/SESSION[/KEY=VALUE…]#[SECRET.CERTIFICATE.]CHECK
///
/// It has no space and no character that a mail program or an unquoted word of a shell changes.
/// There is one spelling of each invitation. CHECK tells accidents in copying. Who alters a line on
/// purpose meets the proof of the enrolment, which covers all before the '#'.
struct Invitation {
  static constexpr std::size_t kMostHosts = 8;
  static constexpr std::size_t kMostOthers = 15;
  static constexpr std::size_t kLongest = 2000;  // bytes
  static constexpr std::size_t kLongestSession = 128;

  std::string session;
  Role role = Role::kActive;
  bool secured = false;
  std::uint32_t domain = 42;
  std::vector<std::string> hosts;   // the inviter's machine, HOST or HOST:PORT (UDP)
  std::vector<std::string> others;  // further machines of the session, likewise
  InvitedScene scene;
  EnrolmentTerms enrolment;  // of a secured session

  friend bool operator==(const Invitation&, const Invitation&) = default;
};

/// The line. The invitation must be one that ReadInvitation() gives.
std::string LineOf(const Invitation& invitation);

/// Whether a text is meant as such a line.
bool IsInvitationLine(std::string_view text);

/// Reads a line, with the space or the angle brackets that copying left round it. An error says
/// what is wrong with it, and what to do.
Result<Invitation> ReadInvitation(std::string_view text);

/// What a proof is of: the line as far as it is no secret.
std::string OpenPartOf(const std::string& line);

/// "14:05 UTC", for a person, with the day where it is another than that of `now`.
std::string TimeForAPerson(std::time_t time, std::time_t now);

}  // namespace tandem
