#include "app/view/ui/dialogs/join_dialog.h"

#include <QComboBox>
#include <QFile>
#include <QLineEdit>
#include <QListWidget>
#include <QPushButton>
#include <QSpinBox>
#include <QTemporaryDir>
#include <QTest>
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

// In place of `tandem` a program that writes its arguments down, and has a session in domain 7
// alone.
TEST(JoinDialog, LooksForSessionsByItsFields) {
  const QTemporaryDir folder;
  const QString program = folder.filePath("tandem");
  QFile script(program);
  ASSERT_TRUE(script.open(QIODevice::WriteOnly));
  script.write(
      "#!/bin/sh\n"
      "case \"$*\" in\n"
      "'sessions --json --domain 7 --interface lo --peers 10.0.0.2,b.example:7410')\n"
      "  echo '{\"sessions\": [{\"session\": \"press\"}]}' ;;\n"
      "*) echo '{\"sessions\": []}' ;;\n"
      "esac\n"
      "sleep 0.1\n");
  script.close();
  script.setPermissions(QFile::ReadOwner | QFile::WriteOwner | QFile::ExeOwner);
  JoinDialog dialog;
  HandRequest request;
  request.interface = "lo";
  request.peers = {"10.0.0.2", "b.example:7410"};
  request.domain = 6;
  dialog.SetRequest(request, true);
  dialog.Look(program);
  const auto shows = [&](const QString& text) {
    return ProcessEventsUntil([&] {
      const auto* list = dialog.findChild<QListWidget*>("join_sessions");
      return list->count() == 1 && list->item(0)->text().contains(text);
    });
  };
  EXPECT_TRUE(shows("no session"));
  dialog.findChild<QSpinBox*>("join_domain")->setValue(7);
  EXPECT_TRUE(shows("press"));
  dialog.findChild<QLineEdit*>("join_interface")->clear();
  EXPECT_TRUE(shows("no session"));
}

// A name that nobody answers to, or of a session that was left, is not proposed again.
TEST_F(HandWindow, JoinDialogProposesNoSessionThatWasLeft) {
  const auto proposed = [&] {
    Action("join_session_action")->trigger();
    auto* dialog = window_.findChild<JoinDialog*>();
    const QString session = dialog->findChild<QLineEdit*>("join_session")->text();
    delete dialog;
    return session;
  };
  HandRequest request;
  request.session = "bracket";
  request.name = "anna";
  window_.Join(request, false);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session_.state() == SessionModel::State::kJoined;
  }));
  EXPECT_EQ(proposed(), "") << "nobody answers";
  fake_.inbox->OnPeerInfo(FakeSession::Info(5, "ben", Role::kActive), 0);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session_.has_peers();
  }));
  EXPECT_EQ(proposed(), "bracket");
  session_.Leave();
  EXPECT_EQ(proposed(), "");
}

TEST(JoinDialog, ReturnInAFieldTakesPart) {
  JoinDialog dialog;
  HandRequest request;
  request.session = "press";
  request.name = "anna";
  dialog.SetRequest(request, true);
  dialog.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&dialog));
  QTest::keyClick(dialog.findChild<QLineEdit*>("join_name"), Qt::Key_Return);
  EXPECT_EQ(dialog.result(), QDialog::Accepted);
  EXPECT_FALSE(dialog.isVisible());
}

TEST(JoinDialog, ReturnInTheListTakesPartInItsSession) {
  JoinDialog dialog;
  HandRequest request;
  request.session = "left before";
  request.name = "anna";
  dialog.SetRequest(request, true);
  dialog.ShowSessions(R"({"sessions": [{"session": "a"}, {"session": "b"}]})");
  dialog.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&dialog));
  auto* list = dialog.findChild<QListWidget*>("join_sessions");
  list->setFocus();
  list->setCurrentRow(0);
  QTest::keyClick(list, Qt::Key_Down);
  QTest::keyClick(list, Qt::Key_Return);
  EXPECT_EQ(dialog.Request().session, "b");
  EXPECT_EQ(dialog.result(), QDialog::Accepted);
}

// The command line refuses the domains beyond it.
TEST(JoinDialog, OffersTheDomainsOfTheCommandLine) {
  const JoinDialog dialog;
  EXPECT_EQ(dialog.findChild<QSpinBox*>("join_domain")->maximum(), 230);
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
