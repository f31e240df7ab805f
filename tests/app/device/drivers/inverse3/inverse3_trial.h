#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/app/device/driver_trial.h"
#include "tests/app/device/drivers/inverse3/fake_service.h"

namespace tandem::testing {

/// A driver and a service, and the forces that the vendor's thread is given.
struct Inverse3Trial {
  explicit Inverse3Trial(const std::string& options = "",
                         const std::function<void(FakeWorld&)>& change = {}) {
    if (change) service.Change(change);
    trial.SetTake([this](TandemDeviceForce& force) {
      force.force[0] = fx.load();
      force.force[1] = fy.load();
      force.force[2] = fz.load();
    });
    opened = trial.Open(service.ports() + (options.empty() ? "" : "," + options));
    EXPECT_EQ(opened, TANDEM_OK) << trial.Error();
    if (opened == TANDEM_OK) {
      EXPECT_EQ(trial.Start(), TANDEM_OK);
    }
  }
  bool Reads(std::int32_t code) {
    trial.Ticks(1);
    return trial.TicksUntil([&] {
      return trial.read() == code ||
             (code == TANDEM_OK && trial.read() == TANDEM_REPEATED && trial.state().time_ns != 0);
    });
  }
  void Ask(double x, double y, double z) {
    fx = x;
    fy = y;
    fz = z;
  }
  /// Returns the force of the newest message that came to the service.
  Vec3 Asked(const char* form = "vector") const {
    using nlohmann::json;
    const json message = json::parse(service.newest(), nullptr, false);
    try {
      const json& f = message.at("inverse3").at(0).at("commands").at("set_cursor_force").at(form);
      return Vec3(f.at("x").get<double>(), f.at("y").get<double>(), f.at("z").get<double>());
    } catch (const json::exception&) {
      return Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  bool AsksFor(const Vec3& force, const char* form = "vector") {
    return trial.TicksUntil([&] {
      return (Asked(form) - force).norm() < 1e-4;
    });
  }

  FakeService service;
  std::atomic<double> fx{0}, fy{0}, fz{0};
  DriverTrial trial{"inverse3"};  // goes first
  std::int32_t opened = TANDEM_FAILED;
};

}  // namespace tandem::testing
