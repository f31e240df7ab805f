#include "app/join/member_files.h"

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/output_file.h"
#include "app/invite/enrolment.h"
#include "collab/dds/security/keys.h"
#include "collab/dds/security/member_request.h"
#include "collab/dds/security/unfinished_folder.h"
#include "engine/base/files/regular_file.h"
#include "engine/base/files/whole_file.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLargestAnswer = EnrolmentAnswer::kLongest;
constexpr const char* kRequestFile = "request.pem";
constexpr const char* kKeyFile = "identity.key";

/// Returns the folder in which the private key waits for its certificate.
fs::path Waiting(const std::string& folder) {
  fs::path path = fs::path(folder).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  return path.string() + ".request";
}

int AskByFile(const std::string& folder) {
  std::error_code failed;
  if (fs::exists(folder, failed)) {
    return Fail(kExitFile, folder + " exists already: name a new folder");
  }
  Result<UnfinishedFolder> made = UnfinishedFolder::Make(Waiting(folder));
  if (!made) return Fail(kExitFile, made.error().what);
  const Result<std::string> request = MakeMemberRequest(made->path() / kKeyFile);
  if (!request) return Fail(kExitSecurity, request.error().what);
  if (const auto fault = WriteWholeFile(made->path() / kRequestFile, *request)) {
    return Fail(kExitFile, fault->what);
  }
  const Result<std::string> digest = DigestToCompare(made->path() / kRequestFile);
  if (!digest) return Fail(kExitSecurity, digest.error().what);
  if (const Result<bool> done = made->Commit(); !done) return Fail(kExitFile, done.error().what);
  const std::string file = (Waiting(folder) / kRequestFile).string();
  Say("send " + file + " to the owner of the session's keys; the rest of that folder stays here");
  Say("its digest, to compare on the telephone: " + *digest);
  Say("then, with the answer file: tandem keys take " + folder + " ANSWER");
  return kExitOk;
}

struct AnswerArguments {
  std::string session;
  std::string name;
  std::string request;
  std::string out;
  std::string role = "active";
  int days = 365;
};

int AnswerRequest(const AnswerArguments& arguments) {
  const std::string out = arguments.out.empty() ? arguments.name + ".answer" : arguments.out;
  std::error_code failed;
  if (fs::exists(out, failed)) return Fail(kExitFile, out + " exists already: name it with --out");
  if (const std::string fault = WhyNotWritable(out); !fault.empty()) return Fail(kExitFile, fault);
  if (!fs::exists(fs::path(arguments.session) / "identity_ca.key", failed)) {
    return Fail(kExitFile, arguments.session +
                               ": holds no session's keys: 'tandem keys session' "
                               "makes them");
  }
  const Result<std::string> request = ReadWholeFile(arguments.request, EnrolmentRequest::kLongest);
  if (!request) return Fail(kExitFile, request.error().what);
  const Result<std::string> digest = DigestToCompare(arguments.request);
  if (!digest) return Fail(kExitSecurity, digest.error().what);
  EnrolmentAnswer answer;
  answer.session = arguments.session;
  answer.name = arguments.name;
  answer.role = arguments.role == "viewer" ? Role::kViewer : Role::kActive;
  Result<MemberFiles> files =
      SignMember(arguments.session, arguments.name, answer.role, *request, arguments.days);
  if (!files) return Fail(kExitSecurity, arguments.request + ": " + files.error().what);
  answer.files = *std::move(files);
  if (const auto fault = WriteWholeFile(out, TextOf(answer))) return Fail(kExitFile, fault->what);
  const Result<std::string> given = DigestToCompare(out);
  if (!given) return Fail(kExitSecurity, given.error().what);
  Say("digest of the request: " + *digest + "; is it what " + arguments.name +
      " reads out on the telephone? If it is not, tandem keys revoke " + arguments.session + " " +
      arguments.name);
  Say("send " + out + " back; nothing in it is secret. Its digest: " + *given);
  return kExitOk;
}

int TakeAnswer(const std::string& folder, const std::string& file) {
  const fs::path waiting = Waiting(folder);
  std::error_code failed;
  if (!fs::exists(waiting / kKeyFile, failed)) {
    return Fail(kExitFile, waiting.string() + ": holds no waiting request: 'tandem keys request " +
                               folder + "' makes one");
  }
  const Result<std::string> text = ReadWholeFile(file, kLargestAnswer);
  if (!text) return Fail(kExitFile, text.error().what);
  const Result<EnrolmentAnswer> answer = ReadEnrolmentAnswer(*text);
  if (!answer || !answer->refused.empty()) {
    return Fail(kExitFile, file + ": is not an answer file of 'tandem keys answer'");
  }
  const Result<std::string> digest = DigestToCompare(file);
  if (!digest) return Fail(kExitSecurity, digest.error().what);
  const Result<MemberKeys> keys = TakeMember(waiting / kKeyFile, answer->files, folder);
  if (!keys) return Fail(kExitSecurity, file + ": " + keys.error().what);
  fs::remove_all(waiting, failed);
  Say("digest of the answer, to compare on the telephone: " + *digest);
  Say(folder + " is all that " + keys->name + " needs: give the folder to nobody else, then " +
      (keys->role == Role::kViewer ? "tandem watch" : "tandem peer") + " --secure " + folder);
  return kExitOk;
}

CLI::Validator MemberName() {
  return CLI::Validator(
      [](std::string& name) -> std::string {
        return IsMemberName(name)
                   ? ""
                   : "'" + name + "' is not a member's name: use letters, digits, '.', '_' and '-'";
      },
      "");
}

}  // namespace

void AddMemberFileCommands(CLI::App& keys, int& exit_code) {
  auto folder = std::make_shared<std::string>();
  CLI::App* request = keys.add_subcommand(
      "request", "Ask for a certificate through a file; the private key stays on this machine");
  request->add_option("FOLDER", *folder, "new folder for the keys, once the answer is there")
      ->required();
  request->callback([folder, &exit_code] {
    exit_code = AskByFile(*folder);
  });

  auto arguments = std::make_shared<AnswerArguments>();
  CLI::App* answer = keys.add_subcommand("answer", "Make a member from a request file");
  answer->add_option("FOLDER", arguments->session, "folder of the session")->required();
  answer->add_option("NAME", arguments->name, "name that others see")
      ->required()
      ->check(MemberName());
  answer->add_option("REQUEST", arguments->request, "request file of 'tandem keys request'")
      ->required();
  answer->add_option("--role", arguments->role, "active: take part; viewer: look on")
      ->check(OneOf({"active", "viewer"}))
      ->capture_default_str();
  answer->add_option("--out", arguments->out, "new answer file; default: NAME.answer");
  answer->add_option("--days", arguments->days, "validity of the member's keys, days")
      ->check(WholeNumberFrom(1, 36'500))
      ->capture_default_str();
  answer->callback([arguments, &exit_code] {
    exit_code = AnswerRequest(*arguments);
  });

  auto into = std::make_shared<std::string>();
  auto file = std::make_shared<std::string>();
  CLI::App* take = keys.add_subcommand("take", "Complete a member's folder with the answer file");
  take->add_option("FOLDER", *into, "folder of 'tandem keys request'")->required();
  take->add_option("ANSWER", *file, "answer file of 'tandem keys answer'")->required();
  take->callback([into, file, &exit_code] {
    exit_code = TakeAnswer(*into, *file);
  });
}

}  // namespace tandem
