#include <atomic>
#include <memory>
#include <random>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/bench/bench_commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/stop_signal.h"
#include "app/process/child_processes.h"
#include "collab/dds/diagnostics/round_trip.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

struct NetworkArguments {
  RoundTripOptions trips;
  std::uint16_t echo_port = 0;  // not 0: this is the echo process
  bool json = false;
};

double Microseconds(const Histogram& ns, double q) {
  return 1e-3 * static_cast<double>(ns.Quantile(q));
}

int Tell(const NetworkArguments& arguments, const RoundTrips& trips) {
  if (trips.udp.count() == 0 || trips.dds.count() == 0) {
    return Fail(kExitNetwork, "no packet came back");
  }
  const double udp_us = Microseconds(trips.udp, 0.5);
  const double dds_us = Microseconds(trips.dds, 0.5);
  const char* scheduler = trips.fifo ? "SCHED_FIFO" : "SCHED_OTHER";
  if (arguments.json) {
    const nlohmann::ordered_json json = {{"udp_rtt_p50_us", udp_us},
                                         {"dds_rtt_p50_us", dds_us},
                                         {"ratio", dds_us / udp_us},
                                         {"udp_rtt_p99_us", Microseconds(trips.udp, 0.99)},
                                         {"dds_rtt_p99_us", Microseconds(trips.dds, 0.99)},
                                         {"round_trips", trips.udp.count()},
                                         {"udp_lost", trips.udp_lost},
                                         {"dds_lost", trips.dds_lost},
                                         {"bytes", RoundTrips::kDatagramBytes},
                                         {"scheduler", scheduler}};
    std::printf("%s\n", JsonText(json, 2).c_str());
  } else {
    std::printf(
        "round trip, %zu bytes, %s: UDP %.1f us (p99 %.1f), DDS %.1f us (p99 %.1f), ratio %.2f\n",
        RoundTrips::kDatagramBytes, scheduler, udp_us, Microseconds(trips.udp, 0.99), dds_us,
        Microseconds(trips.dds, 0.99), dds_us / udp_us);
  }
  return kExitOk;
}

int RunEcho(const NetworkArguments& arguments) {
  const Result<bool> done = EchoRoundTrips(arguments.trips, arguments.echo_port, StopOnSignals());
  return done ? kExitOk : Fail(kExitNetwork, done.error().what);
}

int RunBenchNetwork(NetworkArguments arguments) {
  if (arguments.echo_port != 0) return RunEcho(arguments);
  arguments.trips.session =
      "bench-" + std::to_string(getpid()) + "-" + std::to_string(std::random_device{}());
  Result<RoundTripMeter> meter = RoundTripMeter::Open();
  if (!meter) return Fail(kExitNetwork, meter.error().what);
  const Result<ChildProcess> echo = ChildProcess::Start(
      {(ProgramFolder() / "tandem").string(), "bench", "network", "--echo-session",
       arguments.trips.session, "--echo-port", std::to_string(meter->port()), "--domain",
       std::to_string(arguments.trips.domain)});
  if (!echo) return Fail(kExitFailed, echo.error().what);
  const Result<RoundTrips> trips = meter->Measure(arguments.trips);
  return trips ? Tell(arguments, *trips) : Fail(kExitNetwork, trips.error().what);
}

}  // namespace

void AddBenchNetwork(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<NetworkArguments>();
  CLI::App* command = bench.add_subcommand(
      "network", "Measure round trips between two processes, by DDS and by a plain UDP socket");
  command->add_option("--seconds", arguments->trips.seconds, "duration of the measurement, s")
      ->check(NumberFrom(0.1, 600))
      ->capture_default_str();
  command->add_option("--domain", arguments->trips.domain, "DDS domain, a number")
      ->check(WholeNumberFrom(0, 230));
  command->add_flag("--json", arguments->json, "print one JSON object");
  // the two options below make it the other process; an empty group hides them from the help
  command->add_option("--echo-session", arguments->trips.session)->group("");
  command->add_option("--echo-port", arguments->echo_port)
      ->group("")
      ->check(WholeNumberFrom(0, 65535));
  command->callback([arguments, &exit_code] {
    exit_code = RunBenchNetwork(*arguments);
  });
}

}  // namespace tandem
