#include "collab/lab/metrics/metrics_table.h"

namespace tandem {

std::span<const MetricField> MetricFields() {
  static constexpr MetricField kAll[] = {{"growth", &Metrics::growth},
                                         {"windows", &Metrics::windows},
                                         {"tail_rms", &Metrics::tail_rms},
                                         {"generated_J", &Metrics::generated_J},
                                         {"peak_apart", &Metrics::peak_apart},
                                         {"last_apart", &Metrics::last_apart},
                                         {"peak_turn", &Metrics::peak_turn},
                                         {"settle_s", &Metrics::settle_s},
                                         {"band_low_rms", &Metrics::band_low_rms},
                                         {"band_high_rms", &Metrics::band_high_rms},
                                         {"peak_force", &Metrics::peak_force},
                                         {"peak_force_rate", &Metrics::peak_force_rate},
                                         {"link_force", &Metrics::link_force},
                                         {"link_force_rate", &Metrics::link_force_rate},
                                         {"guarded_share", &Metrics::guarded_share},
                                         {"clip_share", &Metrics::clip_share},
                                         {"stiffness", &Metrics::stiffness},
                                         {"least_stiffness", &Metrics::least_stiffness},
                                         {"loop_age_s", &Metrics::loop_age_s},
                                         {"te_s", &Metrics::te_s},
                                         {"blew_up", &Metrics::diverged},
                                         {"frames", &Metrics::frames},
                                         {"trapped_frames", &Metrics::trapped_frames}};
  return kAll;
}

}  // namespace tandem
