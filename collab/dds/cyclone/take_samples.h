#pragma once

#include <array>
#include <cstddef>

#include "collab/dds/cyclone/dds_api.h"

namespace tandem {

/// Calls use(sample, info) for all waiting samples of a reader; a sample without data has only its
/// key. `Wire` is the type that the reader receives.
template <typename Wire, typename Use>
void TakeSamples(dds_entity_t reader, const Use& use) {
  constexpr std::size_t kBatch = 16;
  dds_return_t taken = 0;
  do {
    std::array<void*, kBatch> samples{};
    std::array<dds_sample_info_t, kBatch> infos{};
    taken = dds_take(reader, samples.data(), infos.data(), kBatch, kBatch);
    for (int i = 0; i < taken; ++i) {
      const auto k = static_cast<std::size_t>(i);
      use(*static_cast<const Wire*>(samples[k]), infos[k]);
    }
    if (taken > 0) dds_return_loan(reader, samples.data(), taken);
  } while (taken == static_cast<dds_return_t>(kBatch));
}

/// Calls use(sample) for all waiting samples of a reader that have data.
template <typename Wire, typename Use>
void TakeData(dds_entity_t reader, const Use& use) {
  TakeSamples<Wire>(reader, [&](const Wire& wire, const dds_sample_info_t& info) {
    if (info.valid_data) use(wire);
  });
}

}  // namespace tandem
