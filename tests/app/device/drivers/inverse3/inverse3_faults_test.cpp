// Tests faults of a service and its device while they run, of the table in inverse3_test.cpp.
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/app/device/drivers/inverse3/inverse3_trial.h"

namespace tandem::testing {
namespace {

using nlohmann::json;

TEST(Inverse3, ReportsAServiceThatLagsBehind) {
  Inverse3Trial it("", [](FakeWorld& world) {
    world.follows = "values";
  });
  ASSERT_TRUE(it.Reads(TANDEM_OK));
  it.Ask(0, 1, 0);
  ASSERT_TRUE(it.Reads(TANDEM_FAILED));
  EXPECT_NE(it.trial.Error().find("force=values"), std::string::npos) << it.trial.Error();
  EXPECT_TRUE(it.AsksFor(Vec3::Zero()));
}

TEST(Inverse3, EachArmConditionHasItsCodeAndMessage) {
  Inverse3Trial it;
  it.Ask(1, 0, 0);
  struct Case {
    std::function<void(FakeWorld&)> fault;
    std::int32_t code;
    const char* word;
  };
  const Case cases[] = {
      {[](FakeWorld& world) {
         world.arm = "";
       },
       TANDEM_UNPLUGGED, "USB cable"},
      {[](FakeWorld& world) {
         world.arm = "0000";
       },
       TANDEM_UNPLUGGED, "'049D'"},
      {[](FakeWorld& world) {
         world.powered = false;
       },
       TANDEM_UNPLUGGED, "power supply"},
      {[](FakeWorld& world) {
         world.ready = false;
       },
       TANDEM_UNPLUGGED, "not ready"},
      {[](FakeWorld& world) {
         world.calibrated = false;
       },
       TANDEM_UNCALIBRATED, "calibrated"},
  };
  for (const Case& one : cases) {
    it.service.Change([](FakeWorld& world) {
      world = FakeWorld();
    });
    ASSERT_TRUE(it.Reads(TANDEM_OK)) << one.word;
    ASSERT_TRUE(it.AsksFor(Vec3(1, 0, 0))) << one.word;
    it.service.Change(one.fault);
    ASSERT_TRUE(it.Reads(one.code)) << one.word;
    EXPECT_NE(it.trial.Error().find(one.word), std::string::npos) << it.trial.Error();
    EXPECT_TRUE(it.AsksFor(Vec3::Zero())) << one.word;
  }
}

TEST(Inverse3, SleepingGripCountsAsUnplugged) {
  Inverse3Trial it("grip=wireless", [](FakeWorld& world) {
    world.grip_kind = "wireless_verse_grip";
  });
  ASSERT_TRUE(it.Reads(TANDEM_OK));
  for (const char* status : {R"("connected":true,"awake":false)", R"("connected":false)"}) {
    it.service.Change([&](FakeWorld& world) {
      world.grip_status = status;
    });
    ASSERT_TRUE(it.Reads(TANDEM_UNPLUGGED));
    EXPECT_NE(it.trial.Error().find("'G1'"), std::string::npos) << it.trial.Error();
    it.service.Change([](FakeWorld& world) {
      world.grip_status = R"("awake":true)";
    });
    ASSERT_TRUE(it.Reads(TANDEM_OK));
  }
}

TEST(Inverse3, EventsRemoveTheForce) {
  Inverse3Trial it;
  ASSERT_TRUE(it.Reads(TANDEM_OK));
  ASSERT_TRUE(it.trial.TicksUntil([&] {
    return it.service.Listens();
  }));
  it.Ask(1, 0, 0);
  // other devices, other events and what is no event
  for (const char* text : {R"({"name":"device-busy","data":{"device_id":"other"}})",
                           R"({"name":"session-started"})", R"({"name":7})", "{{{", "[]"}) {
    it.service.Tell(text);
  }
  it.trial.Ticks(50);
  EXPECT_GE(it.trial.read(), 0);
  struct Case {
    const char* text;
    std::int32_t code;
    const char* word;
  };
  const Case cases[] = {
      {R"({"name":"device-safety-triggered","message":"stall_detected","data":{"device_id":"049D"}})",
       TANDEM_UNPLUGGED, "stall_detected"},
      {R"({"name":"device-busy"})", TANDEM_UNPLUGGED, "another program"},
      {R"({"name":"device-disconnected"})", TANDEM_UNPLUGGED, "USB"},
      {R"({"name":"device-calibration-failed"})", TANDEM_UNCALIBRATED, "calibrated"},
  };
  for (const Case& one : cases) {
    it.service.Tell(one.text);
    ASSERT_TRUE(it.Reads(one.code)) << one.text;
    EXPECT_NE(it.trial.Error().find(one.word), std::string::npos) << it.trial.Error();
    EXPECT_TRUE(it.AsksFor(Vec3::Zero()));
    it.service.Tell(R"({"name":"device-connected"})");
    ASSERT_TRUE(it.Reads(TANDEM_OK));
  }
  // without that word it goes on a second later
  it.service.Tell(cases[0].text);
  ASSERT_TRUE(it.Reads(TANDEM_UNPLUGGED));
  ASSERT_TRUE(it.Reads(TANDEM_OK));
  EXPECT_TRUE(it.AsksFor(Vec3(1, 0, 0)));
}

TEST(Inverse3, ContinuesAfterAServiceRestart) {
  Inverse3Trial it;
  ASSERT_TRUE(it.Reads(TANDEM_OK));
  it.Ask(1, 0, 0);
  ASSERT_TRUE(it.AsksFor(Vec3(1, 0, 0)));
  const Vec3 last = it.trial.position();
  it.service.Kick(true);
  ASSERT_TRUE(it.Reads(TANDEM_UNPLUGGED));
  EXPECT_NE(it.trial.Error().find("systemctl start"), std::string::npos) << it.trial.Error();
  EXPECT_EQ(it.trial.position(), last);
  it.service.Change([](FakeWorld& world) {
    world.x = -0.03;
  });
  it.service.Reopen();
  ASSERT_TRUE(it.Reads(TANDEM_OK));
  EXPECT_TRUE(it.trial.TicksUntil([&] {
    return it.trial.position().x() == -0.03;
  }));
  EXPECT_EQ(json::parse(it.service.first()).count("session"), 1U);  // it introduces itself again
  EXPECT_TRUE(it.AsksFor(Vec3(1, 0, 0)));
  it.trial.ExpectRealtime();
}

TEST(Inverse3, SilentServiceCountsAsUnplugged) {
  Inverse3Trial it;
  ASSERT_TRUE(it.Reads(TANDEM_OK));
  it.service.Change([](FakeWorld& world) {
    world.silent = true;
  });
  ASSERT_TRUE(it.Reads(TANDEM_UNPLUGGED));
  EXPECT_NE(it.trial.Error().find("silent"), std::string::npos) << it.trial.Error();
  // it ends at once all the same
  const auto begun = std::chrono::steady_clock::now();
  it.trial.Close();
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(2));
}

TEST(Inverse3, InvalidMessagesEndTheConnection) {
  const std::string head = R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":)";
  const std::string tail = R"(,"cursor_velocity":{"x":0,"y":0,"z":0}}}]})";
  const std::string unsound[] = {
      "hello",
      "[]",
      R"({"inverse3":7)",
      head + R"({"x":NaN,"y":0,"z":0})" + tail,
      head + R"({"x":"0","y":0,"z":0})" + tail,
      head + R"({"x":1e300,"y":0,"z":0})" + tail,
      head + R"({"x":1e999,"y":0,"z":0})" + tail,
      head + R"({"x":0,"y":0})" + tail,
      head + "null" + tail,
      std::string(60000, '['),
  };
  Inverse3Trial it;
  ASSERT_TRUE(it.Reads(TANDEM_OK));
  const Vec3 last = it.trial.position();
  for (const std::string& text : unsound) {
    // a few are passed over, or the device is silent for a moment
    const long before = it.service.messages();
    it.service.Change([&](FakeWorld& world) {
      world.instead = text;
    });
    it.trial.TicksUntil([&] {
      return it.service.messages() > before + 4;
    });
    it.service.Change([](FakeWorld& world) {
      world.instead.clear();
    });
    ASSERT_TRUE(it.Reads(TANDEM_OK)) << text.substr(0, 100);
    EXPECT_EQ(it.trial.position(), last);
  }
  const long connections = it.service.connections();
  it.service.Change([](FakeWorld& world) {
    world.instead = "hello";
  });
  ASSERT_TRUE(it.Reads(TANDEM_UNPLUGGED));
  EXPECT_TRUE(it.trial.TicksUntil([&] {
    return it.trial.Error().find("cannot be read") != std::string::npos;
  })) << it.trial.Error();
  it.service.Change([](FakeWorld& world) {
    world.instead.clear();
  });
  ASSERT_TRUE(it.Reads(TANDEM_OK));
  EXPECT_GT(it.service.connections(), connections);
  it.service.Change([](FakeWorld& world) {
    world.instead.assign(100000, ' ');
  });
  ASSERT_TRUE(it.Reads(TANDEM_UNPLUGGED));
  it.service.Change([](FakeWorld& world) {
    world.instead.clear();
  });
  ASSERT_TRUE(it.Reads(TANDEM_OK));
  it.trial.ExpectRealtime();
}

}  // namespace
}  // namespace tandem::testing
