#include <memory>

#include "app/cli/commands.h"
#include "app/cli/talk.h"
#include "app/exit_codes.h"
#include "collab/dds/keys.h"

namespace tandem {
namespace {

struct KeysArguments {
  std::string folder;  // the session's
  std::string name;    // the member's
  std::string out;
  std::vector<std::string> identity_authority;  // certificate, key
  std::vector<std::string> permissions_authority;
  int days = 365;
};

Authority AuthorityOf(const std::vector<std::string>& files) {
  return files.empty() ? Authority{} : Authority{.certificate = files[0], .key = files[1]};
}

int MakeSession(const KeysArguments& arguments) {
  const Result<bool> made =
      MakeSessionKeys(arguments.folder, AuthorityOf(arguments.identity_authority),
                      AuthorityOf(arguments.permissions_authority), arguments.days);
  if (!made) return Fail(kExitSecurity, made.error().what);
  Say(arguments.folder + " holds the session's two authorities: keep its .key files to yourself");
  Say("next: tandem keys peer " + arguments.folder + " NAME");
  return kExitOk;
}

enum class Part { kPeer, kViewer, kRelay };

int MakeMember(const KeysArguments& arguments, Part part) {
  const std::string out =
      arguments.out.empty() ? arguments.folder + "/" + arguments.name : arguments.out;
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
  CLI::App* session = keys->add_subcommand("session", "Two new authorities, in a new folder");
  session->add_option("FOLDER", arguments->folder, "new folder")->required();
  session
      ->add_option("--identity-authority", arguments->identity_authority,
                   "certificate and key (PEM) to use instead of a new one")
      ->expected(2);
  session
      ->add_option("--permissions-authority", arguments->permissions_authority,
                   "the same; must be another authority")
      ->expected(2);
  session->add_option("--days", arguments->days, "how long they are valid")
      ->check(CLI::PositiveNumber);
  session->callback([arguments, &exit_code] {
    exit_code = MakeSession(*arguments);
  });

  struct Member {
    Part part;
    const char* name;
    const char* what;
  };
  for (const Member member :
       {Member{Part::kPeer, "peer", "Keys of someone who takes part"},
        Member{Part::kViewer, "viewer", "Keys of someone who looks on"},
        Member{Part::kRelay, "relay",
               "Keys of a relay, for the session of those who look on behind it"}}) {
    auto asked = std::make_shared<KeysArguments>();
    CLI::App* command = keys->add_subcommand(member.name, member.what);
    command->add_option("FOLDER", asked->folder, "the session's folder")->required();
    command->add_option("NAME", asked->name, "how others see them")->required();
    command->add_option("--out", asked->out, "new folder; default: FOLDER/NAME");
    command->add_option("--days", asked->days, "how long they are valid")
        ->check(CLI::PositiveNumber);
    command->callback([asked, part = member.part, &exit_code] {
      exit_code = MakeMember(*asked, part);
    });
  }
}

}  // namespace tandem
