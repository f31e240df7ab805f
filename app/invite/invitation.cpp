#include "app/invite/invitation.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <limits>
#include <optional>

#include "engine/base/files/regular_file.h"
#include "engine/base/hash.h"
#include "engine/base/text/hex.h"

namespace tandem {

namespace {

constexpr std::string_view kScheme = "tandem://";
constexpr std::string_view kDigits64 =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
constexpr std::size_t kCheckSize = 8;
constexpr std::size_t kLongestHost = 253;
constexpr std::uint32_t kDefaultDomain = 42;
constexpr std::uint32_t kMostDomain = 230;

bool IsPlainChar(char c) {  // independent of the locale
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '-';
}

std::string Percented(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (IsPlainChar(c)) {
      out += c;
      continue;
    }
    std::array<char, 4> code{};
    std::snprintf(code.data(), code.size(), "%%%02X",
                  static_cast<unsigned>(static_cast<unsigned char>(c)));
    out += code.data();
  }
  return out;
}

std::optional<std::string> Unpercented(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    unsigned code = 0;
    if (i + 2 >= text.size() ||
        std::from_chars(&text[i] + 1, &text[i] + 3, code, 16).ptr != &text[i] + 3) {
      return std::nullopt;
    }
    out += static_cast<char>(code);
    i += 2;
  }
  return out;
}

/// Encodes in Base64 for URLs, without padding (RFC 4648, section 5).
std::string Base64Of(const Secret128& bytes) {
  std::string out;
  std::uint32_t bits = 0;
  int count = 0;
  for (const std::uint8_t byte : bytes) {
    bits = bits << 8U | byte;
    count += 8;
    while (count >= 6) {
      count -= 6;
      out += kDigits64[bits >> static_cast<unsigned>(count) & 63U];
    }
  }
  return out + kDigits64[bits << static_cast<unsigned>(6 - count) & 63U];
}

std::optional<Secret128> FromBase64(std::string_view text) {
  Secret128 bytes{};
  if (text.size() != 22) return std::nullopt;
  std::uint32_t bits = 0;
  int count = 0;
  std::size_t at = 0;
  for (const char c : text) {
    const std::size_t digit = kDigits64.find(c);
    if (digit == std::string_view::npos) return std::nullopt;
    bits = bits << 6U | static_cast<std::uint32_t>(digit);
    count += 6;
    if (count < 8 || at == bytes.size()) continue;
    count -= 8;
    bytes[at++] = static_cast<std::uint8_t>(bits >> static_cast<unsigned>(count));
  }
  return bytes;
}

template <typename Number>
std::optional<Number> NumberIn(std::string_view text, int base = 10) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, base);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::string CheckOf(std::string_view all_before) {
  Hash64 hash;
  hash.AddBytes(all_before.data(), all_before.size());
  return Hex(hash.value()).substr(0, kCheckSize);
}

std::vector<std::string> Parts(std::string_view text, char separator) {
  std::vector<std::string> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.emplace_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

std::string WithCommas(const std::vector<std::string>& hosts) {
  std::string all;
  for (const std::string& host : hosts) all += (all.empty() ? "" : ",") + host;
  return all;
}

/// Returns whether the text is HOST or HOST:PORT.
bool IsHost(std::string_view text) {
  const std::size_t colon = text.find(':');
  const std::string_view host = text.substr(0, colon);
  if (host.empty() || host.size() > kLongestHost || !std::ranges::all_of(host, IsPlainChar)) {
    return false;
  }
  if (colon == std::string_view::npos) return true;
  const auto port = NumberIn<std::uint16_t>(text.substr(colon + 1));
  return port && *port != 0;
}

bool AreHosts(const std::vector<std::string>& hosts, std::size_t most) {
  return hosts.size() <= most && std::ranges::all_of(hosts, IsHost);
}

std::string OpenPart(const Invitation& invitation) {
  std::string line =
      std::string(kScheme) + WithCommas(invitation.hosts) + "/" + Percented(invitation.session);
  if (invitation.role == Role::kViewer) line += "/role=viewer";
  if (invitation.domain != kDefaultDomain) line += "/domain=" + std::to_string(invitation.domain);
  if (!invitation.others.empty()) line += "/others=" + WithCommas(invitation.others);
  if (const InvitedScene& scene = invitation.scene; scene.digest) {
    line += "/scene=" + HexOfBytes(*scene.digest) + "." + std::to_string(scene.bodies) + "." +
            Percented(scene.file);
  }
  if (invitation.secured) {
    line += "/enrol=" + std::to_string(invitation.enrolment.port);
    line += "/until=" + std::to_string(invitation.enrolment.until);
  }
  return line;
}

/// Reads DIGEST.BODIES.FILE.
bool TakeScene(const std::string& value, InvitedScene& scene) {
  const std::size_t first = value.find('.');
  const std::size_t second = value.find('.', first + 1);
  if (first == std::string::npos || second == std::string::npos) return false;
  Sha256 digest{};
  const auto bodies = NumberIn<std::uint32_t>(value.substr(first + 1, second - first - 1));
  const auto file = Unpercented(value.substr(second + 1));
  if (!FromHexOfBytes(std::string_view(value).substr(0, first), digest) || !bodies || !file ||
      file->size() > InvitedScene::kLongestFile || file->find('/') != std::string::npos) {
    return false;
  }
  scene = {.digest = digest, .bodies = *bodies, .file = *file};
  return true;
}

/// Reads KEY=VALUE into the invitation. False: the key is unknown or the value is invalid.
bool TakeField(const std::string& field, Invitation& invitation) {
  const std::size_t equals = field.find('=');
  if (equals == std::string::npos) return false;
  const std::string key = field.substr(0, equals);
  const std::string value = field.substr(equals + 1);
  if (key == "role") {
    invitation.role = Role::kViewer;
    return value == "viewer";
  }
  if (key == "domain") {
    const auto domain = NumberIn<std::uint32_t>(value);
    invitation.domain = domain.value_or(kMostDomain + 1);
    return invitation.domain <= kMostDomain;
  }
  if (key == "others") {
    invitation.others = Parts(value, ',');
    return AreHosts(invitation.others, Invitation::kMostOthers);
  }
  if (key == "scene") {
    return TakeScene(value, invitation.scene);
  }
  if (key == "enrol") {
    invitation.secured = true;
    invitation.enrolment.port = NumberIn<std::uint16_t>(value).value_or(0);
    return invitation.enrolment.port != 0;
  }
  if (key == "until") {
    invitation.enrolment.until = NumberIn<std::uint32_t>(value).value_or(0);
    return invitation.enrolment.until != 0;
  }
  return false;
}

/// Removes the characters that copying leaves round a line.
std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kRound = " \t\r\n<>'\"";
  const std::size_t first = text.find_first_not_of(kRound);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kRound) + 1 - first);
}

}  // namespace

std::string OpenPartOf(const std::string& line) {
  return line.substr(0, line.find('#'));
}

std::string LineOf(const Invitation& invitation) {
  std::string line = OpenPart(invitation) + "#";
  if (invitation.secured) {
    line += (invitation.enrolment.has_secret ? Base64Of(invitation.enrolment.secret) : "") + ".";
    line += Base64Of(invitation.enrolment.certificate) + ".";
  }
  return line + CheckOf(line);
}

std::string PublicLineOf(Invitation invitation) {
  invitation.enrolment.has_secret = false;
  invitation.enrolment.secret = {};
  return LineOf(invitation);
}

bool IsInvitationLine(std::string_view text) {
  return Trimmed(text).substr(0, kScheme.size()) == kScheme;
}

Result<Invitation> ReadInvitation(std::string_view text, LineForm form) {
  const std::string_view line = Trimmed(text);
  if (!IsInvitationLine(line)) {
    return Error{"an invitation begins with tandem://: copy the whole line of 'tandem invite'"};
  }
  if (line.size() > Invitation::kLongest)
    return Error{
        "the line is too long for an invitation: copy exactly the line of 'tandem invite'"};
  // checked before the fields: a damaged line cannot tell which version wrote it
  const Error damaged{
      "the line is incomplete or changed: copy the whole line of 'tandem invite', from tandem:// "
      "to the last letter, or ask for a new one"};
  if (line.size() <= kCheckSize ||
      CheckOf(line.substr(0, line.size() - kCheckSize)) != line.substr(line.size() - kCheckSize)) {
    return damaged;
  }
  const std::size_t hash = line.find('#');
  if (hash == std::string_view::npos) return damaged;
  const std::vector<std::string> parts =
      Parts(line.substr(kScheme.size(), hash - kScheme.size()), '/');
  Invitation invitation;
  const auto session = parts.size() < 2 ? std::nullopt : Unpercented(parts[1]);
  invitation.hosts = Parts(parts[0], ',');
  if (!session || session->empty() || session->size() > Invitation::kLongestSession ||
      !AreHosts(invitation.hosts, Invitation::kMostHosts)) {
    return damaged;
  }
  invitation.session = *session;
  for (std::size_t i = 2; i < parts.size(); ++i) {
    if (!TakeField(parts[i], invitation)) {
      return Error{
          "the invitation is from another version of Tandem: update all participants to one "
          "version"};
    }
  }
  const std::vector<std::string> secrets = Parts(line.substr(hash + 1), '.');
  if (invitation.secured) {
    const bool is_public = secrets.size() == 3 && secrets[0].empty();
    const auto secret = secrets.size() == 3 && !is_public ? FromBase64(secrets[0]) : std::nullopt;
    const auto certificate = secrets.size() == 3 ? FromBase64(secrets[1]) : std::nullopt;
    if (!(secret || is_public) || !certificate || invitation.enrolment.until == 0) return damaged;
    if (is_public && form == LineForm::kWhole) {
      return Error{
          "this is the public form of an invitation, for 'tandem doctor' alone: use the line that "
          "you were given, or ask for a new one"};
    }
    invitation.enrolment.has_secret = !is_public;
    invitation.enrolment.secret = secret.value_or(Secret128{});
    invitation.enrolment.certificate = *certificate;
  }
  // anybody can make a CHECK, and these go to a terminal
  if (!IsPlainText(invitation.session) || !IsPlainText(invitation.scene.file)) {
    return Error{
        "the line names a session or a scene with control characters, which no session has: do not "
        "use it, and ask the inviter for a new one"};
  }
  // one spelling each: the proof could not tell apart two spellings of one invitation
  if (LineOf(invitation) != line) return damaged;
  return invitation;
}

std::string TimeForAPerson(std::time_t time, std::time_t now) {
  std::tm utc{};
  std::tm today{};
  gmtime_r(&time, &utc);
  gmtime_r(&now, &today);
  const bool same_day = utc.tm_yday == today.tm_yday && utc.tm_year == today.tm_year;
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), same_day ? "%H:%M UTC" : "%Y-%m-%d %H:%M UTC", &utc);
  return text.data();
}

}  // namespace tandem
