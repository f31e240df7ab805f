#include "app/view/ui/dialogs/invite_dialog.h"

#include <QApplication>
#include <QClipboard>
#include <QComboBox>
#include <QLineEdit>
#include <QListWidget>
#include <QPushButton>
#include <QSpinBox>

#include <gtest/gtest.h>

#include "app/invite/invitation.h"
#include "app/view/ui/dialogs/join_dialog.h"
#include "tests/app/view/fake_session.h"
#include "tests/support/scratch_folder.h"

// Tests how the window invites, and joins by an invitation.

namespace tandem {
namespace {

HandRequest OnLoopback() {
  HandRequest request;
  request.session = "invite dialog";
  request.scene = TANDEM_SCENES "/peg_in_slot.json";
  request.interface = "lo";
  return request;
}

QString FieldText(const QWidget& dialog, const char* name) {
  return dialog.findChild<QLineEdit*>(name)->text();
}

Invitation Plain() {
  Invitation invitation;
  invitation.session = "Nose gear";
  invitation.hosts = {"192.0.2.1"};
  invitation.domain = 7;
  return invitation;
}

TEST(InviteDialog, CreatesAndCopiesAnInvitation) {
  InviteDialog dialog(OnLoopback(), TANDEM_PROGRAM);
  EXPECT_EQ(dialog.Fault(), QString());
  dialog.findChild<QComboBox*>("invite_role")->setCurrentIndex(1);
  dialog.findChild<QPushButton*>("invite_make")->click();
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return !FieldText(dialog, "invite_line").isEmpty();
  }));
  const QString line = FieldText(dialog, "invite_line");
  const Result<Invitation> read = ReadInvitation(line.toStdString());
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->session, "invite dialog");
  EXPECT_EQ(read->role, Role::kViewer);
  EXPECT_EQ(read->scene.file, "peg_in_slot.json");
  EXPECT_EQ(QGuiApplication::clipboard()->text(), line);
}

TEST(InviteDialog, SecuredSessionAsksForNameAndKeys) {
  const ScratchFolder folder;
  HandRequest request = OnLoopback();
  request.secure = (folder.path() / "anna").string();
  std::filesystem::create_directories(request.secure);
  InviteDialog without(request, TANDEM_PROGRAM);
  EXPECT_FALSE(without.Fault().isEmpty());
  EXPECT_FALSE(without.findChild<QPushButton*>("invite_make")->isEnabled());

  folder.Write("identity_ca.key", "");  // the session's folder lies about the member's
  InviteDialog dialog(request, TANDEM_PROGRAM);
  EXPECT_EQ(FieldText(dialog, "invite_keys").toStdString(), folder.path().string());
  dialog.findChild<QLineEdit*>("invite_name")->setText("a b");
  EXPECT_FALSE(dialog.Fault().isEmpty());
  dialog.findChild<QLineEdit*>("invite_name")->setText("ben");
  EXPECT_EQ(dialog.Fault(), QString());
  EXPECT_TRUE(dialog.Words().contains("--keys"));
  // the program says that this folder makes no members
  dialog.findChild<QPushButton*>("invite_make")->click();
  auto* state = dialog.findChild<QLabel*>("invite_state");
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return state->text().contains("cannot make members");
  })) << state->text().toStdString();
}

TEST(JoinDialog, InvitationFillsMostFields) {
  JoinDialog dialog;
  HandRequest request;
  request.name = "ben";
  dialog.SetRequest(request, true);
  auto* invitation = dialog.findChild<QLineEdit*>("join_invitation");
  auto* accept = dialog.findChild<QPushButton*>("join_accept");
  const QString line = QString::fromStdString(LineOf(Plain()));
  invitation->setText(line.left(30));
  EXPECT_TRUE(dialog.Fault().contains("copy the whole line")) << dialog.Fault().toStdString();
  EXPECT_FALSE(accept->isEnabled());
  invitation->setText(" " + line + "\n");
  EXPECT_EQ(dialog.Fault(), QString());
  EXPECT_TRUE(accept->isEnabled());
  EXPECT_EQ(dialog.Request().session, "Nose gear");
  EXPECT_EQ(dialog.Request().domain, 7U);
  EXPECT_FALSE(dialog.findChild<QLineEdit*>("join_session")->isEnabled());
  Invitation viewer = Plain();
  viewer.role = Role::kViewer;
  invitation->setText(QString::fromStdString(LineOf(viewer)));
  EXPECT_FALSE(dialog.active());
}

TEST(JoinDialog, ListsOpenSessionsAndUsesTheChosenOne) {
  JoinDialog dialog;
  auto* list = dialog.findChild<QListWidget*>("join_sessions");
  dialog.ShowSessions("{\"sessions\":[]}");
  EXPECT_EQ(list->count(), 1);  // a line says that there is none
  dialog.ShowSessions(R"({"sessions":[{"session":"gear","secured":true,"relay":false},)"
                      R"({"session":"wing","secured":false,"relay":false},)"
                      R"({"session":"wing","secured":false,"relay":true}]})");
  ASSERT_EQ(list->count(), 2);
  EXPECT_TRUE(list->item(0)->text().contains("secured"));
  Q_EMIT list->itemClicked(list->item(1));
  EXPECT_EQ(FieldText(dialog, "join_session"), "wing");
}

}  // namespace
}  // namespace tandem
