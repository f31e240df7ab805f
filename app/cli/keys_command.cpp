#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include <sys/stat.h>
#include <unistd.h>

#include "app/cli/commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/join/member_files.h"
#include "collab/dds/security/keys.h"
#include "collab/dds/security/revocation.h"

namespace tandem {
namespace {

struct KeysArguments {
  std::string folder;  // folder of the session
  std::string name;    // name of the member
  std::string out;
  std::vector<std::string> identity_authority;  // certificate, key
  std::vector<std::string> permissions_authority;
  int days = 365;
  bool audience = false;  // the session is that of a relay's viewers
};

Authority AuthorityOf(const std::vector<std::string>& files) {
  return files.empty() ? Authority{} : Authority{.certificate = files[0], .key = files[1]};
}

/// Returns what speaks against a new folder on the disk; empty: nothing.
std::string WhyNoFolder(const std::filesystem::path& folder) {
  std::error_code failed;
  if (std::filesystem::exists(folder, failed) && !std::filesystem::is_empty(folder, failed)) {
    return folder.string() + " exists already: keys are never overwritten; name a new folder";
  }
  std::filesystem::path first_new = std::filesystem::absolute(folder);
  while (!std::filesystem::exists(first_new.parent_path(), failed)) {
    first_new = first_new.parent_path();
  }
  if (std::filesystem::exists(folder, failed)) return {};
  if (mkdir(first_new.c_str(), 0700) != 0) {
    return folder.string() + ": cannot be made: " + std::strerror(errno) + ": name another folder";
  }
  rmdir(first_new.c_str());
  return {};
}

int MakeSession(const KeysArguments& arguments) {
  const std::string fault = WhyNoFolder(arguments.folder);
  if (!fault.empty()) return Fail(kExitFile, fault);
  const Result<bool> made =
      MakeSessionKeys(arguments.folder, AuthorityOf(arguments.identity_authority),
                      AuthorityOf(arguments.permissions_authority), arguments.days,
                      arguments.audience ? SessionKind::kAudience : SessionKind::kMembers);
  if (!made) return Fail(kExitSecurity, made.error().what);
  Say(arguments.folder +
      " holds the session's two certificate authorities: keep its .key files to yourself");
  Say(std::string("next: tandem keys ") + (arguments.audience ? "relay " : "peer ") +
      arguments.folder + " NAME");
  return kExitOk;
}

int Revoke(const KeysArguments& arguments) {
  const Result<RevokedMember> done = RevokeMember(arguments.folder, arguments.out);
  if (!done) return Fail(kExitSecurity, done.error().what);
  Say(done->name + " (" + Hex(done->peer) + ") is revoked: copy " + arguments.folder +
      "/revoked.p7s and " + arguments.folder +
      "/identity.crl into the folder of every remaining member, then restart their programs; new "
      "members get both files");
  return kExitOk;
}

/// Tells in a table what each sort of member may do.
void TellRights() {
  for (const char* line :
       {"                                     peer     viewer   relay's audience side",
        "made in the folder of                session  either   audience",
        "appear under the name of its keys    yes      yes      as each peer it shows",
        "hold bodies, as their authority      yes      no       no",
        "offer a scene                        yes      no       as each peer it shows",
        "see bodies move                      yes      yes      no",
        "review notes, cameras (to come)      yes      yes      as each peer it shows",
        "files of scenes                      yes      reads    as each peer it shows"}) {
    PrintText(line);
  }
}

enum class Part { kPeer, kViewer, kRelay };

int MakeMember(const KeysArguments& arguments, Part part) {
  const std::string out =
      arguments.out.empty() ? arguments.folder + "/" + arguments.name : arguments.out;
  std::string fault = WhyNoFolder(out);
  std::error_code failed;
  if (!std::filesystem::is_directory(arguments.folder, failed)) {
    fault = arguments.folder + ": no such folder: 'tandem keys session " + arguments.folder +
            "' makes it";
  }
  if (fault.empty() && !std::filesystem::exists(arguments.folder + "/identity_ca.pem", failed)) {
    fault = arguments.folder + ": holds no session's keys: 'tandem keys session' makes them";
  }
  if (!fault.empty()) return Fail(kExitFile, fault);
  const Result<PeerId> made =
      part == Part::kRelay ? MakeRelayKeys(arguments.folder, arguments.name, out, arguments.days)
                           : MakeMemberKeys(arguments.folder, arguments.name,
                                            part == Part::kViewer ? Role::kViewer : Role::kActive,
                                            out, arguments.days);
  if (!made) return Fail(kExitSecurity, made.error().what);
  const char* next = part == Part::kPeer     ? "tandem peer --secure FOLDER"
                     : part == Part::kViewer ? "tandem watch --secure FOLDER"
                                             : "tandem relay --audience-secure FOLDER";
  Say(out + " is all that " + arguments.name + " needs: give the folder to nobody else, then " +
      next);
  return kExitOk;
}

}  // namespace

void AddKeysCommand(CLI::App& app, int& exit_code) {
  CLI::App* keys = app.add_subcommand("keys", "Make the keys of a secured session");
  keys->require_subcommand(1);

  auto arguments = std::make_shared<KeysArguments>();
  CLI::App* session = keys->add_subcommand(
      "session", "Make a session's two certificate authorities, in a new folder");
  session->add_option("FOLDER", arguments->folder, "new folder for the session's keys")->required();
  session
      ->add_option("--identity-authority", arguments->identity_authority,
                   "certificate and key (PEM) to use as identity authority; default: a new one")
      ->expected(2);
  session
      ->add_option("--permissions-authority", arguments->permissions_authority,
                   "certificate and key (PEM) to use as permissions authority, another one; "
                   "default: a new one")
      ->expected(2);
  session->add_option("--days", arguments->days, "validity of the certificate authorities, days")
      ->check(WholeNumberFrom(1, 36'500));
  session->add_flag("--audience", arguments->audience,
                    "make the session of the viewers behind a relay, whose authorities must not be "
                    "the session's own");
  session->callback([arguments, &exit_code] {
    exit_code = MakeSession(*arguments);
  });

  auto revoked = std::make_shared<KeysArguments>();
  CLI::App* revoke = keys->add_subcommand("revoke", "Exclude a member from now on");
  revoke->add_option("FOLDER", revoked->folder, "folder of the session")->required();
  revoke
      ->add_option("MEMBER", revoked->out,
                   "member's folder, or the member's name or id in FOLDER/members.txt")
      ->required();
  revoke->callback([revoked, &exit_code] {
    exit_code = Revoke(*revoked);
  });
  AddMemberFileCommands(*keys, exit_code);
  keys->add_subcommand("rights", "Show what each kind of keys allows")->callback([] {
    TellRights();
  });

  struct Member {
    Part part;
    const char* name;
    const char* what;
  };
  for (const Member member :
       {Member{Part::kPeer, "peer", "Make the keys of a participant"},
        Member{Part::kViewer, "viewer", "Make the keys of a viewer"},
        Member{Part::kRelay, "relay",
               "Make the keys of a relay, for the session of the viewers behind it"}}) {
    auto made = std::make_shared<KeysArguments>();
    CLI::App* command = keys->add_subcommand(member.name, member.what);
    command
        ->add_option("FOLDER", made->folder,
                     member.part == Part::kRelay ? "folder made by 'tandem keys session --audience'"
                                                 : "folder of the session")
        ->required();
    command->add_option("NAME", made->name, "name that others see")
        ->required()
        ->check(CLI::Validator(
            [](std::string& name) -> std::string {
              return IsMemberName(name)
                         ? ""
                         : "'" + name +
                               "' is not a member's name: use letters, digits, '.', '_' and '-'";
            },
            ""));
    command->add_option("--out", made->out, "new folder for the keys; default: FOLDER/NAME");
    command
        ->add_option(
            "--days", made->days,
            "validity of the keys, days; at most that of the session's certificate authorities")
        ->check(WholeNumberFrom(1, 36'500));
    command->callback([made, part = member.part, &exit_code] {
      exit_code = MakeMember(*made, part);
    });
  }
}

}  // namespace tandem
