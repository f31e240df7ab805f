#include <algorithm>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "app/invite/invitation.h"
#include "tests/app/cli/program_run.h"
#include "tests/support/scratch_folder.h"

// Tests that nothing of a name, a line or a path reaches the terminal but plain text: another
// person may have sent it to be pasted.

namespace tandem {
namespace {

using ::testing::HasSubstr;
using testing::ProgramOutput;
using testing::RunTandem;

// sets the title, clears the screen, begins a line of its own, and turns the direction of writing
constexpr const char* kEvil =
    "'a\x1b]0;PWNED\x07\x1b[2J\ntandem: your keys expired\xe2\x80\xae\xc2\x9b\x7f'";

/// Expects plain text, in which no line begins as the program's own and is not.
void ExpectPlain(const std::string& words, const ProgramOutput& output) {
  for (const std::string& text : {output.out, output.err}) {
    const bool plain = std::ranges::all_of(text, [](char c) {
      const auto byte = static_cast<unsigned char>(c);
      return byte == '\n' || (byte >= 0x20 && byte != 0x7F);
    });
    EXPECT_TRUE(plain) << words << ": "
                       << nlohmann::json(text).dump(-1, ' ', true,
                                                    nlohmann::json::error_handler_t::replace);
    // C1 and the marks of direction, as UTF-8
    EXPECT_EQ(text.find("\xc2\x9b"), std::string::npos) << words;
    EXPECT_EQ(text.find("\xe2\x80\xae"), std::string::npos) << words;
    EXPECT_EQ(("\n" + text).find("\ntandem: your keys"), std::string::npos) << words;
  }
}

TEST(HostileWords, NoControlCharacterOfAWordReachesTheTerminal) {
  const std::string evil = kEvil;
  for (const std::string& words :
       std::vector<std::string>{evil,
                                "peer --" + evil,
                                "peer --session " + evil,
                                "watch --session " + evil,
                                "relay --session " + evil,
                                "join " + evil,
                                "open " + evil,
                                "invite " + evil,
                                "doctor --session " + evil,
                                "doctor --json --scene " + evil,
                                "doctor --interface " + evil,
                                "doctor --json --invitation " + evil,
                                "doctor --invitation " + evil,
                                "peer --session s --interface " + evil,
                                "peer --session s --peers " + evil,
                                "peer --session s --external-address " + evil,
                                "peer --session s --scene " + evil,
                                "peer --session s --secure " + evil,
                                "peer --session s --law " + evil,
                                "sessions --seconds 0.1 --interface " + evil,
                                "join @" + evil,
                                "voxelize --voxel 0.01 " + evil,
                                "contact --voxel 0.01 --static x --dynamic x --poses " + evil,
                                "contact --voxel 0.01 --dynamic x --poses x --static " + evil,
                                "proximity " + evil,
                                "replay " + evil,
                                "replay x --export " + evil,
                                "clearance " + evil,
                                "study " + evil,
                                "stability run " + evil,
                                "stability sweep " + evil,
                                "stability trace " + evil + " --out x.csv",
                                "stability report " + evil + " --out x",
                                "keys peer " + evil + " anna",
                                "simulate --scene " + evil,
                                "devices --try " + evil,
                                "view --scene " + evil,
                                "view --session " + evil, 
                                "bench " + evil}) {
    ExpectPlain(words, RunTandem(words, "timeout 20 "));
  }
}

TEST(HostileWords, ForgedInvitationIsRefusedInPlainWords) {
  Invitation forged{.session = "sec-\x1b]0;PWNED\x07\x1b[2J\ntandem: your keys expired",
                    .hosts = {"127.0.0.1"}};
  const ScratchFolder folder;
  const std::string line = folder.Write("line", LineOf(forged) + "\n").string();
  for (const std::string& words : {"join @" + line, "doctor --invitation @" + line}) {
    const ProgramOutput output = RunTandem(words, "timeout 20 ");
    EXPECT_THAT(output.out + output.err, HasSubstr("control characters")) << words;
    ExpectPlain(words, output);
  }
}

}  // namespace
}  // namespace tandem
