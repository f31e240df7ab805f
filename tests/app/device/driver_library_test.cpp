#include "app/device/driver_library.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "app/device/open_driver.h"
#include "app/process/child_processes.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;

const std::filesystem::path kUnsound = TANDEM_UNSOUND_DRIVERS;

std::string FaultOf(const std::filesystem::path& file) {
  const Result<const TandemDriver*> driver = DriverLibrary::Load(file);
  return driver ? "" : driver.error().what;
}

TEST(DriverLibrary, LoadsADriverOfTheBuildTree) {
  const Result<const TandemDriver*> fake =
      DriverLibrary::Load(std::filesystem::path(TANDEM_DRIVER_FOLDER) / "fake.so");
  ASSERT_TRUE(fake) << fake.error().what;
  EXPECT_STREQ((*fake)->name, "fake");
}

TEST(DriverLibrary, ExplainsInvalidLibraryFiles) {
  const TemporaryFolder folder;
  const std::filesystem::path text = folder.path() / "text.so";
  std::ofstream(text) << "no library";
  EXPECT_THAT(FaultOf(text), HasSubstr("cannot be loaded"));
  EXPECT_THAT(FaultOf(folder.path() / "none.so"), HasSubstr("cannot be loaded"));
  EXPECT_THAT(FaultOf(kUnsound / "empty.so"), HasSubstr("it exports no tandem_driver"));
  EXPECT_THAT(FaultOf(kUnsound / "newer.so"), HasSubstr("built for version 2 of the interface"));
  EXPECT_THAT(FaultOf(kUnsound / "lacking.so"), HasSubstr("a function or a text"));
  EXPECT_THAT(FaultOf(kUnsound / "misnamed.so"), HasSubstr("its driver is called 'unsound'"));
}

TEST(DriverLibrary, FindsDriversInTheFirstFolderThatHasThem) {
  const TemporaryFolder first;
  const TemporaryFolder second;
  for (const char* file : {"arm.so", "Upper.so", "note.txt"}) std::ofstream(first.path() / file);
  for (const char* file : {"arm.so", "pen-2.so"}) std::ofstream(second.path() / file);
  const std::string folders = ":" + first.path().string() + ":" + second.path().string() + ":/none";
  ASSERT_EQ(setenv("TANDEM_DEVICES", folders.c_str(), 1), 0);
  const std::vector<DriverFile> found = FindDrivers();
  unsetenv("TANDEM_DEVICES");
  const auto file_of = [&found](const std::string& name) {
    const auto one = std::ranges::find(found, name, &DriverFile::name);
    return one == found.end() ? std::filesystem::path() : one->file;
  };
  EXPECT_EQ(file_of("arm"), first.path() / "arm.so");
  EXPECT_EQ(file_of("pen-2"), second.path() / "pen-2.so");
  EXPECT_EQ(file_of("Upper"), "");
  EXPECT_EQ(file_of("note"), "");
}

// loading a library runs its code as the user
TEST(DriverLibrary, DriversThatOtherUsersCanWriteAreNotLoaded) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "fake.so";
  std::filesystem::copy_file(std::filesystem::path(TANDEM_DRIVER_FOLDER) / "fake.so", file);
  const auto refusal = [&] {
    EXPECT_EQ(setenv("TANDEM_DEVICES", folder.path().c_str(), 1), 0);
    const Result<const TandemDriver*> driver = DriverNamed("fake");
    unsetenv("TANDEM_DEVICES");
    return driver ? "" : driver.error().what;
  };
  ASSERT_EQ(chmod(file.c_str(), 0644), 0);
  EXPECT_EQ(refusal(), "");
  ASSERT_EQ(chmod(file.c_str(), 0646), 0);
  EXPECT_THAT(refusal(), HasSubstr("other users can write to it"));
  ASSERT_EQ(chmod(file.c_str(), 0644), 0);
  ASSERT_EQ(chmod(folder.path().c_str(), 0777), 0);
  EXPECT_THAT(refusal(), HasSubstr("other users can write to it"));
  ASSERT_EQ(chmod(folder.path().c_str(), 0755), 0);
  if (geteuid() != 0) GTEST_SKIP() << "root alone can give a file to another user";
  ASSERT_EQ(chown(file.c_str(), 65534, 65534), 0);
  EXPECT_THAT(refusal(), HasSubstr("belongs to another user"));
}

}  // namespace
}  // namespace tandem
