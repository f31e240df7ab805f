#include "app/view/ui/dialogs/join_dialog.h"

#include <QComboBox>
#include <QLineEdit>
#include <QPushButton>
#include <array>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "app/invite/invitation.h"
#include "tests/app/view/ui/hand_window_fixture.h"

namespace tandem {
namespace {

TEST_F(HandWindow, JoiningLooksForTheSceneFirst) {
  HandRequest request;
  request.session = "bracket";
  request.name = "anna";
  request.control = "test";
  scene_.OpenNamed("elsewhere.json");
  window_.Join(request, false);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session_.state() == SessionModel::State::kJoined;
  }));
  EXPECT_EQ(hand_.state(), HandModel::State::kNone);  // a viewer has no hand
}

// The program `tandem` itself, which lies beside this test, reads the invitation.
TEST_F(HandWindow, InvitationOpensItsSession) {
  const std::size_t launched = controller_.launched.size();
  Action("join_session_action")->trigger();
  auto* dialog = window_.findChild<JoinDialog*>();
  ASSERT_NE(dialog, nullptr);
  Invitation invitation;
  invitation.session = "Nose gear";
  invitation.hosts = {"127.0.0.1"};
  invitation.domain = 44;
  const auto set = [&](const char* field, const QString& text) {
    dialog->findChild<QLineEdit*>(field)->setText(text);
  };
  set("join_invitation", QString::fromStdString(LineOf(invitation)));
  set("join_scene", TANDEM_SCENES "/peg_in_slot.json");
  dialog->findChild<QPushButton*>("join_accept")->click();
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return controller_.launched.size() == launched + 1;
  }));
  const HandRequest& request = controller_.launched.back();
  EXPECT_EQ(request.session, "Nose gear");
  EXPECT_EQ(request.domain, 44U);
  EXPECT_EQ(request.interface, "lo");
  EXPECT_EQ(request.secure, "");
}

TEST(JoinDialog, OffersAllCommandLineOptionsAndReportsErrors) {
  JoinDialog dialog;
  EXPECT_FALSE(dialog.Fault().isEmpty());
  HandRequest request;
  request.session = "S";
  request.name = "anna";
  request.peers = {"192.168.1.2", "host.example:7410"};
  request.external_address = "1.2.3.4";
  request.port = 7500;
  request.domain = 7;
  request.interface = "eth0";
  dialog.SetRequest(request, true);
  EXPECT_EQ(dialog.Fault(), QString());
  const HandRequest back = dialog.Request();
  EXPECT_EQ(back.peers, request.peers);
  EXPECT_EQ(back.external_address, "1.2.3.4");
  EXPECT_EQ(back.port, 7500);
  EXPECT_EQ(back.domain, 7U);
  EXPECT_EQ(back.interface, "eth0");
  EXPECT_TRUE(dialog.active());
  const auto set = [&](const char* field, const char* text) {
    dialog.findChild<QLineEdit*>(field)->setText(text);
  };
  auto* accept = dialog.findChild<QPushButton*>("join_accept");
  for (const auto& [field, wrong, right] :
       std::vector<std::array<const char*, 3>>{{"join_peers", "host:99999", "host:7410"},
                                               {"join_external", "300.1.1.1", "30.1.1.1"},
                                               {"join_secure", "/no/such/folder", ""},
                                               {"join_scene", "/no/such.json", ""},
                                               {"join_session", "", "S"}}) {
    set(field, wrong);
    EXPECT_FALSE(dialog.Fault().isEmpty()) << field;
    EXPECT_FALSE(accept->isEnabled()) << field;
    set(field, right);
    EXPECT_TRUE(dialog.Fault().isEmpty()) << field << dialog.Fault().toStdString();
  }
  dialog.findChild<QComboBox*>("join_role")->setCurrentIndex(1);
  EXPECT_FALSE(dialog.active());
}

}  // namespace
}  // namespace tandem
