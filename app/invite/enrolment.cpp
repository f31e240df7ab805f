#include "app/invite/enrolment.h"

#include <algorithm>
#include <charconv>

#include <nlohmann/json.hpp>

#include "engine/base/files/regular_file.h"
#include "engine/base/text/hex.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

constexpr int kVersion = 1;
constexpr std::size_t kMostFiles = 16;
constexpr std::size_t kLongestReason = 300;

bool ReadHex(const std::string& text, Digest256& digest) {
  if (text.size() != 2 * digest.size()) return false;
  for (std::size_t i = 0; i < digest.size(); ++i) {
    const char* const at = text.data() + 2 * i;
    if (std::from_chars(at, at + 2, digest[i], 16).ptr != at + 2) return false;
  }
  return true;
}

/// Returns the text under a key; empty: there is none.
std::string TextIn(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

/// Returns an object of this version, or null. The message's length bounds its depth and size.
nlohmann::json ObjectIn(const std::string& text, std::size_t longest) {
  if (text.size() > longest) return {};
  nlohmann::json object = nlohmann::json::parse(text, nullptr, false);
  if (!object.is_object()) return {};
  const auto version = object.find("tandem_enrolment");
  return version != object.end() && *version == kVersion ? object : nlohmann::json();
}

}  // namespace

Digest256 ProofOf(const Invitation& invitation, const Digest256& binding) {
  std::string text = "tandem enrolment 1\n" + OpenPartOf(LineOf(invitation)) + "\n";
  text.append(binding.begin(), binding.end());
  return KeyedDigest(invitation.enrolment.secret, text);
}

std::string TextOf(const EnrolmentRequest& request) {
  const nlohmann::json object{{"tandem_enrolment", kVersion},
                              {"proof", HexOfBytes(request.proof)},
                              {"certificate_request", request.certificate_request}};
  return JsonText(object) + "\n";
}

std::string TextOf(const EnrolmentAnswer& answer) {
  nlohmann::json object{{"tandem_enrolment", kVersion}};
  if (!answer.refused.empty()) {
    object["refused"] = answer.refused;
  } else {
    object["session"] = answer.session;
    object["name"] = answer.name;
    object["role"] = answer.role == Role::kViewer ? "viewer" : "active";
    object["files"] = answer.files;
  }
  return JsonText(object) + "\n";
}

Result<EnrolmentRequest> ReadEnrolmentRequest(const std::string& text) {
  const nlohmann::json object = ObjectIn(text, EnrolmentRequest::kLongest);
  EnrolmentRequest request;
  if (!object.is_object() || !ReadHex(TextIn(object, "proof"), request.proof)) {
    return Error{"no request of an enrolment"};
  }
  request.certificate_request = TextIn(object, "certificate_request");
  return request;
}

Result<EnrolmentAnswer> ReadEnrolmentAnswer(const std::string& text) {
  const Error bad{"the inviter has another version of Tandem: update both to one version"};
  const nlohmann::json object = ObjectIn(text, EnrolmentAnswer::kLongest);
  if (!object.is_object()) return bad;
  EnrolmentAnswer answer;
  answer.refused = PlainLine(TextIn(object, "refused"), kLongestReason);
  if (!answer.refused.empty()) return answer;
  answer.session = TextIn(object, "session");
  answer.name = TextIn(object, "name");
  const std::string role = TextIn(object, "role");
  const auto files = object.find("files");
  if (answer.session.empty() || (role != "active" && role != "viewer") || files == object.end() ||
      !files->is_object() || files->empty() || files->size() > kMostFiles) {
    return bad;
  }
  answer.role = role == "viewer" ? Role::kViewer : Role::kActive;
  for (const auto& [name, content] : files->items()) {
    if (!content.is_string()) return bad;
    answer.files[name] = content.get<std::string>();
  }
  return answer;
}

}  // namespace tandem
