#pragma once

#include <ctime>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "collab/dds/security/keys.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {

inline constexpr std::time_t kDay = 86'400;  // s

inline void Replace(const std::filesystem::path& file, const std::filesystem::path& by) {
  std::filesystem::copy_file(by, file, std::filesystem::copy_options::overwrite_existing);
}

/// A session with a member anna.
class MemberFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(MakeSessionKeys(session()).has_value());
    const Result<PeerId> made = MakeMemberKeys(session(), "anna", Role::kActive, anna(), 30);
    ASSERT_TRUE(made.has_value()) << made.error().what;
  }
  std::filesystem::path session() const { return scratch_.path() / "s"; }
  std::filesystem::path anna() const { return session() / "anna"; }
  std::string WhyNot(std::time_t now = std::time(nullptr)) const {
    const Result<MemberKeys> keys = LoadMemberKeys(anna(), now);
    return keys ? "" : keys.error().what;
  }

  ScratchFolder scratch_;
};

}  // namespace tandem::testing
