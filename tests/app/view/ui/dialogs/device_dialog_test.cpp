#include "app/view/ui/dialogs/device_dialog.h"

#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QTest>
#include <QTreeWidget>

#include <gtest/gtest.h>

#include "tests/app/view/fake_session.h"

namespace tandem {
namespace {

const QByteArray kDevices = R"({"devices": [
  {"name": "inverse3", "kind": "Haply Inverse3", "model": "", "present": false,
   "missing": "the Haply service <b>does not answer</b>", "mend": "systemctl start haply-inverse-service"},
  {"name": "spacemouse", "kind": "SpaceMouse", "model": "SpaceMouse Pro", "present": true,
   "missing": "", "mend": ""}]})";

template <typename T>
T* ChildOf(const DeviceDialog& dialog, const char* name) {
  T* child = dialog.findChild<T*>(name);
  EXPECT_NE(child, nullptr) << name;
  return child;
}

TEST(DeviceDialogTest, ListsMouseAndDevicesWithRemedies) {
  DeviceDialog dialog("");
  dialog.ShowDevices(kDevices);
  auto* list = ChildOf<QTreeWidget>(dialog, "devices");
  ASSERT_EQ(list->topLevelItemCount(), 3);
  EXPECT_EQ(dialog.device(), "");
  list->setCurrentItem(list->topLevelItem(1));
  EXPECT_EQ(list->topLevelItem(1)->text(1), "missing");
  EXPECT_EQ(dialog.device(), "inverse3");
  EXPECT_EQ(ChildOf<QLabel>(dialog, "mend")->text(),
            "Missing: the Haply service <b>does not answer</b>\nTo fix it: systemctl start "
            "haply-inverse-service");
  list->setCurrentItem(list->topLevelItem(2));
  EXPECT_EQ(dialog.device(), "spacemouse");
  EXPECT_EQ(ChildOf<QLabel>(dialog, "mend")->text(), "");
  list->setCurrentItem(list->topLevelItem(0));
  EXPECT_EQ(dialog.device(), "");
}

TEST(DeviceDialogTest, DeviceListKeepsTypedOptions) {
  DeviceDialog dialog("spacemouse:mode=camera");
  dialog.ShowDevices(kDevices);
  EXPECT_EQ(dialog.device(), "spacemouse:mode=camera");
  EXPECT_EQ(ChildOf<QTreeWidget>(dialog, "devices")->currentItem()->text(0), "spacemouse");
}

TEST(DeviceDialogTest, SurvivesAMissingProgramAndAnInvalidAnswer) {
  DeviceDialog dialog("");
  dialog.Look("/nonexistent/tandem");
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return ChildOf<QLabel>(dialog, "mend")->text().contains("cannot be started");
  }));
  dialog.Look("/bin/echo");
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return ChildOf<QLabel>(dialog, "mend")->text().isEmpty();
  }));
  EXPECT_EQ(ChildOf<QTreeWidget>(dialog, "devices")->topLevelItemCount(), 1);
}

}  // namespace
}  // namespace tandem
