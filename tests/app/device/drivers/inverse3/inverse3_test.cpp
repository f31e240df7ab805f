// The driver of the Inverse3 against a service of the published interface. Faults that are
// injected, here or in inverse3_faults_test.cpp:
//
// | fault | test |
// |---|---|
// | no service; a service without devices | ListNamesDevicesAndRemedies |
// | wrong options, no arm, no service | OpenReportsWhatIsMissing |
// | a service that restarts | ContinuesAfterAServiceRestart |
// | a service that is silent | SilentServiceCountsAsUnplugged |
// | no device in states; no power; not ready | EachArmConditionHasItsCodeAndMessage |
// | not calibrated | EachArmConditionHasItsCodeAndMessage |
// | grip asleep, not connected | SleepingGripCountsAsUnplugged |
// | forces in a form that the service does not read | ReportsAServiceThatLagsBehind |
// | events: safety, busy, disconnected, calibration failed | EventsRemoveTheForce |
// | no JSON, wrong types, NaN, infinite numbers | UnsoundMessagesAreNoStates… |
// | deep and long messages | UnsoundMessagesAreNoStates… |
// | a force that is no number | NeverRequestsANonFiniteForce |
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/app/device/drivers/inverse3/inverse3_trial.h"

namespace tandem::testing {
namespace {

using nlohmann::json;

TEST(Inverse3, StartsAndReportsMotionInTheDevicesFrame) {
  Inverse3Trial it("", [](FakeWorld& world) {
    world.vx = 0.1;
    world.vy = 0.2;
    world.vz = 0.3;
  });
  ASSERT_TRUE(it.Reads(TANDEM_OK));
  const TandemDeviceCapabilities can = it.trial.Capabilities();
  EXPECT_EQ(can.freedoms_in, 3U);  // no grip
  EXPECT_EQ(can.freedoms_out, 3U);
  EXPECT_NE(can.asks, 0U);
  EXPECT_EQ(can.peak_force, 10);
  // forward is -z here, up is y
  EXPECT_LT((it.trial.position() - Vec3(0.01, 0.15, -0.02)).norm(), 1e-12);
  EXPECT_LT((Vec3(it.trial.state().velocity) - Vec3(0.1, 0.3, -0.2)).norm(), 1e-12);
  EXPECT_EQ(it.trial.state().orientation[3], 1);
  it.service.Change([](FakeWorld& world) {
    world.x = 0.05;
  });
  EXPECT_TRUE(it.trial.TicksUntil([&] {
    return it.trial.position().x() == 0.05;
  }));
  // at most one message a period, and it keeps commanding
  const long before = it.service.messages();
  it.trial.Ticks(500);
  const long sent = it.service.messages() - before;
  RecordProperty("messages_in_500_ms", static_cast<int>(sent));
  EXPECT_GT(sent, 50);
  EXPECT_LT(sent, 600);
  it.trial.ExpectRealtime();
}

TEST(Inverse3, NamesItselfAndItsAxesInTheFirstMessage) {
  Inverse3Trial it("preset=arm_front_centered");
  ASSERT_TRUE(it.Reads(TANDEM_OK));
  const json first = json::parse(it.service.first());
  EXPECT_EQ(first.at("session").at("configure").at("profile").at("name"), "Tandem");
  EXPECT_EQ(first.at("session").at("configure").at("basis").at("permutation"), "XYZ");
  EXPECT_TRUE(first.at("session").contains("force_render_full_state"));
  EXPECT_EQ(first.at("inverse3").at(0).at("configure").at("preset"), "arm_front_centered");
  ASSERT_TRUE(it.trial.TicksUntil([&] {
    return it.service.messages() > 1;
  }));
  EXPECT_FALSE(json::parse(it.service.newest()).contains("session"));
}

TEST(Inverse3, AsksForForcesInTheServicesFrame) {
  Inverse3Trial it;
  ASSERT_TRUE(it.Reads(TANDEM_OK));
  it.Ask(1, 2, 3);
  EXPECT_TRUE(it.AsksFor(Vec3(1, -3, 2)));
  Inverse3Trial older("force=values", [](FakeWorld& world) {
    world.follows = "values";
  });
  ASSERT_TRUE(older.Reads(TANDEM_OK));
  older.Ask(0, 0.5, 0);
  EXPECT_TRUE(older.AsksFor(Vec3(0, 0, 0.5), "values"));
  Inverse3Trial without("force=none");
  ASSERT_TRUE(without.Reads(TANDEM_OK));
  EXPECT_EQ(without.trial.Capabilities().freedoms_out, 0U);
  EXPECT_NE(without.service.newest().find("probe_position"), std::string::npos);
}

TEST(Inverse3, ReadsGripsOfBothKinds) {
  const auto turned = [](const char* kind, const std::string& buttons) {
    return [kind, buttons](FakeWorld& world) {
      world.grip_kind = kind;
      // a quarter turn about the service's z, which is y here
      world.grip_state = R"("orientation":{"w":0.7071068,"x":0,"y":0,"z":0.7071068})" + buttons;
    };
  };
  struct Case {
    const char* kind;
    const char* buttons;
    std::uint32_t pressed;
  };
  const Case cases[] = {
      {"verse_grip", R"(,"button":true,"hall":0)", TANDEM_BUTTON_CLUTCH},
      {"verse_grip", R"(,"button_0":false,"button_1":true)", TANDEM_BUTTON_STOP},
      {"wireless_verse_grip", R"(,"buttons":{"a":true,"b":false,"c":true})", TANDEM_BUTTON_CLUTCH},
      {"wireless_verse_grip", R"(,"buttons":{"button_0":true,"button_1":true})",
       TANDEM_BUTTON_CLUTCH | TANDEM_BUTTON_STOP},
      {"wireless_verse_grip", R"(,"buttons":{"a":1,"b":"yes"})", 0U},
  };
  for (const Case& one : cases) {
    Inverse3Trial it("", turned(one.kind, one.buttons));
    ASSERT_TRUE(it.Reads(TANDEM_OK)) << one.buttons;
    EXPECT_EQ(it.trial.Capabilities().freedoms_in, 6U);
    EXPECT_NEAR(it.trial.state().orientation[1], std::sqrt(0.5), 1e-6);
    EXPECT_NEAR(it.trial.state().orientation[3], std::sqrt(0.5), 1e-6);
    EXPECT_EQ(it.trial.state().buttons, one.pressed) << one.buttons;
  }
}

TEST(Inverse3, StopRemovesTheForceUntilTheNextWrite) {
  Inverse3Trial it;
  ASSERT_TRUE(it.Reads(TANDEM_OK));
  it.Ask(0, 0, 2);
  ASSERT_TRUE(it.AsksFor(Vec3(0, -2, 0)));
  const auto await_zero = [&it] {
    for (int i = 0; i < 1000 && it.Asked() != Vec3::Zero(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  };
  it.trial.Stop();
  await_zero();
  EXPECT_EQ(it.Asked(), Vec3::Zero());
  const long before = it.service.messages();
  while (it.service.messages() < before + 20) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(it.Asked(), Vec3::Zero());  // and it stays so, though forces are taken
  EXPECT_TRUE(it.AsksFor(Vec3(0, -2, 0)));
  it.trial.Close();  // without force
  await_zero();
  EXPECT_EQ(it.Asked(), Vec3::Zero());
}

TEST(Inverse3, NeverRequestsANonFiniteForce) {
  Inverse3Trial it;
  ASSERT_TRUE(it.Reads(TANDEM_OK));
  it.Ask(1, 1, 1);
  ASSERT_TRUE(it.AsksFor(Vec3(1, -1, 1)));
  it.Ask(1, std::numeric_limits<double>::quiet_NaN(), 1);
  EXPECT_TRUE(it.AsksFor(Vec3::Zero()));
  it.Ask(std::numeric_limits<double>::infinity(), 0, 0);
  it.trial.Ticks(20);
  EXPECT_EQ(it.Asked(), Vec3::Zero());
}

TEST(Inverse3, OpenReportsWhatIsMissing) {
  const auto refused = [](const FakeService& service, const std::string& options) {
    DriverTrial trial("inverse3");
    EXPECT_EQ(trial.Open(service.ports() + "," + options), TANDEM_FAILED) << options;
    return trial.Error();
  };
  FakeService service;
  EXPECT_NE(refused(service, "device=1234").find("there are 049D"), std::string::npos);
  EXPECT_NE(refused(service, "grip=wired").find("grip=none"), std::string::npos);
  EXPECT_NE(refused(service, "force=push").find("vector, values or none"), std::string::npos);
  EXPECT_NE(refused(service, "rate=1e9").find("100 to 4000"), std::string::npos);
  EXPECT_NE(refused(service, "preset=a\"b").find("preset"), std::string::npos);
  EXPECT_NE(refused(service, "colour=red").find("'colour'"), std::string::npos);
  service.Change([](FakeWorld& world) {
    world.arm = "";
  });
  EXPECT_NE(refused(service, "").find("sees no Inverse3"), std::string::npos);
  service.Kick(true);
  EXPECT_NE(refused(service, "").find("systemctl start"), std::string::npos);
}

TEST(Inverse3, ListNamesDevicesAndRemedies) {
  const DriverTrial trial("inverse3");
  std::vector<TandemDeviceFound> found = trial.List();
  ASSERT_EQ(found.size(), 1U);
  if (found[0].present != 0) GTEST_SKIP() << "this machine has a service";
  EXPECT_NE(std::string(found[0].missing).find("127.0.0.1:10001"), std::string::npos);
  EXPECT_NE(std::string(found[0].mend).find("systemctl start"), std::string::npos);
  FakeService service(10001);
  found = trial.List();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].present, 1U);
  EXPECT_STREQ(found[0].options, "device=049D");
  EXPECT_NE(std::string(found[0].missing).find("VerseGrip"), std::string::npos);
  service.Change([](FakeWorld& world) {
    world.arm = "";
  });
  found = trial.List();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].present, 0U);
  EXPECT_NE(std::string(found[0].mend).find("USB"), std::string::npos);
}

}  // namespace
}  // namespace tandem::testing
