#pragma once

#include <array>
#include <cstdint>
#include <ctime>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "collab/session/messages.h"
#include "engine/base/files/sha256.h"
#include "engine/base/result.h"

namespace tandem {

using Secret128 = std::array<std::uint8_t, 16>;

/// The part of a line that says how to enrol in a secured session: once, and until `until`.
struct EnrolmentTerms {
  std::uint16_t port = 0;  // TCP port at each of the invitation's hosts
  std::time_t until = 0;
  bool has_secret = true;   // false: the line's public form, with which nobody can enrol
  Secret128 secret{};       // secret that the invited joiner proves to have
  Secret128 certificate{};  // first half of the SHA-256 of the listener's certificate

  friend bool operator==(const EnrolmentTerms&, const EnrolmentTerms&) = default;
};

/// A scene, described so that the joiner can find it on its own machine.
struct InvitedScene {
  static constexpr std::size_t kLongestFile = 100;  // bytes

  std::optional<Sha256> digest;  // digest of the content; nullopt: the line names no scene
  std::uint32_t bodies = 0;
  std::string file;  // file's name without its folder

  friend bool operator==(const InvitedScene&, const InvitedScene&) = default;
};

/// A line that alone tells a person's program how to take part in a session:
///
///     tandem://HOST[:PORT],…/SESSION[/KEY=VALUE…]#[SECRET.CERTIFICATE.]CHECK
///
/// The line of a secured session has a public form, in which SECRET is empty. It serves `tandem
/// doctor` and messages.
///
/// The line has no space, and no character that a mail program or a shell changes in an unquoted
/// word. Each invitation has exactly one spelling. CHECK detects accidents in copying. The proof of
/// the enrolment covers all before the '#', so it detects deliberate changes.
struct Invitation {
  static constexpr std::size_t kMostHosts = 8;
  static constexpr std::size_t kMostOthers = 15;
  static constexpr std::size_t kLongest = 2000;  // bytes
  static constexpr std::size_t kLongestSession = 128;

  std::string session;
  Role role = Role::kActive;
  bool secured = false;
  std::uint32_t domain = 42;
  std::vector<std::string> hosts;   // HOST or HOST:PORT (UDP) of the inviter's machine
  std::vector<std::string> others;  // further machines of the session, in the same form
  InvitedScene scene;
  EnrolmentTerms enrolment;  // only in a secured session

  friend bool operator==(const Invitation&, const Invitation&) = default;
};

/// Returns the invitation's line. The invitation must be one that ReadInvitation() accepts.
std::string LineOf(const Invitation& invitation);

/// Returns whether a text is meant as an invitation's line.
bool IsInvitationLine(std::string_view text);

/// Tells whether a line in its public form is taken.
enum class LineForm : std::uint8_t { kWhole, kWholeOrPublic };

/// Reads a line, and ignores spaces, quotes and angle brackets that copying left round it. An error
/// says what is wrong with the line, and what to do.
Result<Invitation> ReadInvitation(std::string_view text, LineForm form = LineForm::kWhole);

/// Returns the line in its public form, for a message: nobody can enrol with it.
std::string PublicLineOf(Invitation invitation);

/// Returns the public part of a line, which the proof covers: all before the '#'.
std::string OpenPartOf(const std::string& line);

/// Returns a time such as "14:05 UTC" for a person, with the date where it is not that of `now`.
std::string TimeForAPerson(std::time_t time, std::time_t now);

}  // namespace tandem
