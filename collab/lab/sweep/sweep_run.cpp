#include "collab/lab/sweep/sweep_run.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <numeric>
#include <thread>

namespace tandem {

void RunCells(std::span<const SweepCell> cells, unsigned jobs, const CellRunner& run,
              const CellSink& done) {
  std::vector<std::size_t> order(cells.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&cells](std::size_t a, std::size_t b) {
    return cells[a].cost > cells[b].cost;
  });
  std::atomic<std::size_t> next{0};
  std::mutex reporting;
  std::vector<std::thread> workers;
  for (std::size_t t = 0; t < std::min<std::size_t>(std::max(1U, jobs), cells.size()); ++t) {
    workers.emplace_back([&] {
      for (std::size_t i = next++; i < order.size(); i = next++) {
        const SweepCell& cell = cells[order[i]];
        const CellOutcome outcome = run(cell);
        const std::lock_guard<std::mutex> lock(reporting);
        done(cell, outcome);
      }
    });
  }
  for (std::thread& worker : workers) worker.join();
}

}  // namespace tandem
