#include "app/join/join_line.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/program_folders.h"
#include "app/common/scene_files.h"
#include "app/common/stop_signal.h"
#include "app/connection/scene_search.h"
#include "app/invite/enrolment_client.h"
#include "app/invite/invitation.h"
#include "app/join/reach_inviter.h"
#include "app/peer/run_peer.h"
#include "collab/dds/security/keys.h"
#include "collab/dds/security/member_request.h"
#include "collab/dds/security/unfinished_folder.h"
#include "engine/base/files/regular_file.h"
#include "engine/base/text/clean_text.h"
#include "engine/base/text/json_text.h"
#include "engine/realtime/private_process.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLineFile = "invitation.txt";
constexpr std::uintmax_t kLongestLineFile = 4096;

/// Returns the line without its secret, which still differs from all other lines.
std::string NameOfLine(Invitation invitation) {
  invitation.enrolment.secret = {};
  return LineOf(invitation) + "\n";
}

/// Returns the folder `tandem/keys/SESSION-XXXXXXXX` among the user's data. The path is empty where
/// the user has no folder for data.
fs::path FolderForKeys(const Invitation& invitation) {
  const fs::path data = PersonsFolder("XDG_DATA_HOME", ".local/share");
  if (data.empty()) return {};
  std::string name;
  for (const char c : invitation.session) {
    const auto byte = static_cast<unsigned char>(c);
    name += byte < 0x80 && (std::isalnum(byte) != 0 || c == '-' || c == '_') ? c : '_';
  }
  std::string digest;
  for (std::size_t i = 0; i < 4; ++i) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02x",
                  static_cast<unsigned>(invitation.enrolment.certificate[i]));
    digest += digits;
  }
  return data / "keys" / (name.substr(0, 64) + "-" + digest);
}

/// Gets a certificate for a key that it makes here, and makes a member's folder with both.
int GetKeys(const Invitation& invitation, const fs::path& folder) {
  std::error_code failed;
  if (fs::exists(folder, failed)) {
    const Result<std::string> line = ReadWholeFile(folder / kLineFile, kLongestLineFile);
    if (line && *line == NameOfLine(invitation)) {
      Say("the keys that this line gave are in " + folder.string() + ": using them");
      return kExitOk;
    }
    return Fail(kExitFile, folder.string() +
                               " exists already and does not hold keys of this line: name another "
                               "folder with --keys-to");
  }
  fs::create_directories(fs::absolute(folder).parent_path(), failed);
  // checks that there is place for the keys before it uses the line up
  Result<UnfinishedFolder> scratch = UnfinishedFolder::Make(folder.string() + ".key");
  if (!scratch) return Fail(kExitFile, scratch.error().what);
  const fs::path key = scratch->path() / "identity.key";
  const Result<std::string> request = MakeMemberRequest(key);
  if (!request) return Fail(kExitSecurity, request.error().what);
  const std::atomic<bool>& stop = StopOnSignals();
  const EnrolmentOutcome outcome = Enrol(invitation, *request, [&stop] {
    return stop.load();
  });
  if (outcome.fault) {
    const bool nobody = outcome.fault->kind == EnrolmentFault::Kind::kUnreachable;
    return Fail(nobody ? kExitNetwork : kExitSecurity, outcome.fault->what);
  }
  const Result<MemberKeys> keys =
      TakeMember(key, outcome.answer.files, folder, {{kLineFile, NameOfLine(invitation)}});
  if (!keys) return Fail(kExitSecurity, keys.error().what);
  Say("you are a member of session " + CleanText(invitation.session) + " by the name of " +
      CleanText(keys->name) + "; your keys are in " + folder.string());
  return kExitOk;
}

/// Reads the options of tandem peer that came after `--`. Returns in one line what is wrong with
/// them.
std::optional<std::string> ReadFurther(const std::vector<std::string>& words,
                                       PeerArguments& arguments) {
  CLI::App app;
  app.name("tandem peer");
  AddPeerOptions(app, arguments);
  // these are given before `--`, or by the line
  for (const char* option : {"--scene-from-session", "--accept-scene", "--session", "--scene",
                             "--role", "--name", "--hold", "--device", "--interface", "--domain",
                             "--peers", "--external-address", "--port", "--secure"}) {
    app.remove_option(app.get_option(option));
  }
  RefuseEmptyTexts(app);
  std::vector<const char*> argv{"tandem"};
  for (const std::string& word : words) argv.push_back(word.c_str());
  try {
    app.parse(static_cast<int>(argv.size()), argv.data());
  } catch (const CLI::CallForHelp&) {
    return "after -- come options of 'tandem peer --help'";
  } catch (const CLI::ParseError& error) {
    return "after --: " + Explain(app, error);
  }
  return std::nullopt;
}

/// Sets the scene's file if it was named or the line's file is here. Otherwise the session will
/// tell.
void FindLinesScene(const Invitation& invitation, PeerArguments& arguments) {
  if (!arguments.scene.empty()) return;
  if (const InvitedScene& scene = invitation.scene; scene.digest) {
    const auto file = FindScene({.digest = scene.digest,
                                 .file = scene.file,
                                 .bodies = scene.bodies,
                                 .open_told = false,
                                 .fetched = FetchedScenes(arguments.connection.secure)},
                                FoldersWithScenes());
    if (file) {
      Say("the invitation's scene is on this machine: " + file->string());
      arguments.scene = file->string();
      return;
    }
  }
  arguments.scene_from_session = true;
  return;
}

nlohmann::ordered_json AsJson(const Invitation& invitation) {
  nlohmann::ordered_json json{{"session", invitation.session},
                              {"secured", invitation.secured},
                              {"role", invitation.role == Role::kViewer ? "viewer" : "active"}};
  return json;
}

void PrintLine(const nlohmann::ordered_json& json) {
  PrintText(JsonText(json));
  std::fflush(stdout);
}

/// Prints all that a program needs to join by itself.
void PrintWay(const Invitation& invitation, const PeerArguments& arguments) {
  nlohmann::ordered_json json = AsJson(invitation);
  json["domain"] = invitation.domain;
  json["peers"] = arguments.connection.peers;
  json["interface"] = arguments.connection.interface;
  json["keys"] = arguments.connection.secure.empty()
                     ? nlohmann::ordered_json()
                     : nlohmann::ordered_json(arguments.connection.secure);
  json["scene"] =
      arguments.scene.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(arguments.scene);
  PrintLine(json);
}

}  // namespace

int JoinByLine(const JoinLineArguments& requested) {
  const Result<Invitation> invitation = ReadInvitation(requested.line);
  if (!invitation) return Fail(kExitUsage, invitation.error().what);
  if (invitation->secured) KeepProcessPrivate();
  PeerArguments arguments;
  arguments.name = requested.name;
  if (const auto fault = ReadFurther(requested.further, arguments)) return Fail(kExitUsage, *fault);
  const bool viewer = invitation->role == Role::kViewer || requested.role == "viewer";
  if (invitation->secured && !requested.role.empty() &&
      viewer != (invitation->role == Role::kViewer)) {
    return Fail(kExitUsage,
                "--role: this invitation is for an active participant, and so are its keys: ask "
                "for one for a viewer");
  }
  if (invitation->role == Role::kViewer && requested.role == "active") {
    return Fail(kExitUsage,
                "--role: this invitation is for a viewer: ask for one for an active participant");
  }
  arguments.session = invitation->session;
  arguments.role = viewer ? "viewer" : "active";
  arguments.hold = requested.hold;
  arguments.accept_scene = requested.accept_scene;
  if (!requested.device.empty()) arguments.device = requested.device;
  arguments.connection = requested.connection;
  if (!requested.scene.empty()) {
    const Result<Scene> scene = LoadNamedScene(requested.scene);
    if (!scene) return Fail(kExitFile, scene.error().what);
    arguments.scene = scene->file.string();
  }
  // the search listens while the inviter's program signs our key
  InviterSearch search(*invitation, arguments.connection);
  if (invitation->secured && arguments.connection.secure.empty()) {
    const fs::path folder =
        requested.keys_to.empty() ? FolderForKeys(*invitation) : fs::path(requested.keys_to);
    if (folder.empty()) {
      return Fail(kExitFile, "there is no home folder for the keys: name a folder with --keys-to");
    }
    if (const int failed = GetKeys(*invitation, folder); failed != kExitOk) return failed;
    arguments.connection.secure = folder.string();
  }
  if (!invitation->secured && !requested.keys_to.empty()) {
    return Fail(kExitUsage, "--keys-to: the invitation is of a plain session, which has no keys");
  }
  search.End(arguments.connection);
  if (!viewer) FindLinesScene(*invitation, arguments);
  if (StopOnSignals().load()) return kExitOk;
  if (requested.only_keys) {
    if (requested.json) PrintWay(*invitation, arguments);
    return kExitOk;
  }
  arguments.alone =
      "no peer answers in session " + CleanText(invitation->session) +
      ": is the inviter in it? UDP must get through at both sites; check with: tandem "
      "doctor --invitation '" +
      (invitation->secured ? PublicLineOf(*invitation) : LineOf(*invitation)) + "'";
  if (requested.json) {
    arguments.on_entered = [&invitation, &arguments](const EnteredSession& entered) {
      nlohmann::ordered_json json = AsJson(*invitation);
      json["role"] = arguments.role;
      json["peer"] = Hex(entered.peer);
      json["name"] = entered.name;
      json["holding"] = entered.holding.empty() ? nlohmann::ordered_json()
                                                : nlohmann::ordered_json(entered.holding);
      PrintLine(json);
    };
  }
  return RunPeer(arguments);
}

}  // namespace tandem
