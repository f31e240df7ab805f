#include "app/recording/trace_facts.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

#include "collab/receive/link_trace.h"

namespace tandem {

namespace {

struct Way {
  const char* name;
  const std::vector<float>* delay_ms;
};

std::array<Way, 2> WaysOf(const NetworkTrace& trace) {
  return {Way{"there", &trace.there_ms}, Way{"back", &trace.back_ms}};
}

/// Returns the delay below which this share of all samples that arrived stays; 0: none arrived.
double QuantileOf(const std::vector<float>& delay_ms, double share) {
  std::vector<float> arrived;
  std::ranges::copy_if(delay_ms, std::back_inserter(arrived), [](float delay) {
    return delay >= 0;
  });
  if (arrived.empty()) return 0;
  const auto place = static_cast<std::size_t>(share * static_cast<double>(arrived.size() - 1));
  std::nth_element(arrived.begin(), arrived.begin() + static_cast<std::ptrdiff_t>(place),
                   arrived.end());
  return static_cast<double>(arrived[place]);
}

}  // namespace

std::string FactsAsText(const NetworkTrace& trace) {
  std::string text;
  for (const Way& way : WaysOf(trace)) {
    const TraceFacts facts = LinkTrace(trace.rate_hz, *way.delay_ms).facts();
    std::array<char, 256> line{};
    std::snprintf(line.data(), line.size(),
                  "%-5s  %zu samples, %.3f %% lost, %.3f %% overtaken; delay %.2f ms median, %.2f "
                  "ms in 99 %%, %.2f ms at the most; age %.2f ms in the mean, %.2f ms at the "
                  "most\n",
                  way.name, way.delay_ms->size(), 1e2 * facts.loss, 1e2 * facts.overtaken,
                  QuantileOf(*way.delay_ms, 0.5), QuantileOf(*way.delay_ms, 0.99), facts.longest_ms,
                  facts.mean_age_ms, facts.peak_age_ms);
    text += line.data();
  }
  return text;
}

nlohmann::ordered_json FactsAsJson(const NetworkTrace& trace) {
  nlohmann::ordered_json json{{"source", trace.source}, {"rate_hz", trace.rate_hz}};
  json["clock_bound_ms"] = nullptr;
  if (trace.clock_bound_ms >= 0) json["clock_bound_ms"] = trace.clock_bound_ms;
  for (const Way& way : WaysOf(trace)) {
    const TraceFacts facts = LinkTrace(trace.rate_hz, *way.delay_ms).facts();
    json[way.name] = {{"samples", way.delay_ms->size()},
                      {"lost", std::ranges::count_if(*way.delay_ms,
                                                     [](float delay) {
                                                       return delay < 0;
                                                     })},
                      {"loss", facts.loss},
                      {"overtaken", facts.overtaken},
                      {"mean_delay_ms", facts.mean_delay_ms},
                      {"median_delay_ms", QuantileOf(*way.delay_ms, 0.5)},
                      {"delay_99_ms", QuantileOf(*way.delay_ms, 0.99)},
                      {"longest_ms", facts.longest_ms},
                      {"mean_age_ms", facts.mean_age_ms},
                      {"peak_age_ms", facts.peak_age_ms}};
  }
  return json;
}

}  // namespace tandem
