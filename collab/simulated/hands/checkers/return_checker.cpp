#include "collab/simulated/hands/checkers/return_checker.h"

#include <algorithm>

namespace tandem {

void ReturnChecker::CheckPlace(const Taken& taken) {
  if (way_m_ - taken.way_m > kMostWay) return;
  const double away = (held_at_[taken.body].p - taken.X_WB.p).norm();
  if (away <= kNear) return;
  violations_->Add("a way back ends elsewhere than it began", id_, Text("%.1f mm", 1e3 * away));
}

void ReturnChecker::OnAnswer(HostId host, std::uint64_t number, const Answer& answer) {
  const auto requested = requested_.find({host, number});
  if (requested == requested_.end()) return;
  const RetraceRequest::To to = requested->second;
  requested_.erase(requested);
  if (to == RetraceRequest::To::kGrasp) {
    const bool known = !taken_.empty() && taken_.back().body == held_;
    if (answer.ok && known) CheckPlace(taken_.back());
    return;
  }
  if (!answer.ok) {
    // the answer does not say how many ways are forgotten
    taken_.clear();
    all_known_ = false;
  } else if (to == RetraceRequest::To::kUndo) {
    if (taken_.empty()) return;
    CheckPlace(taken_.back());
    taken_.pop_back();
  } else {
    for (std::size_t i = 0; i < taken_.size() && all_known_; ++i) {
      const auto same = [&](const Taken& other) {
        return other.body == taken_[i].body;
      };
      const auto first = std::find_if(taken_.begin(), taken_.end(), same);
      if (first - taken_.begin() == static_cast<std::ptrdiff_t>(i)) CheckPlace(taken_[i]);
    }
    taken_.clear();
    all_known_ = true;
  }
}

void ReturnChecker::Check(const HandObservation& sight, const GoalOrder& order) {
  const int held = sight.attached ? sight.held : -1;
  if (held >= 0 && held == held_) {
    way_m_ += (sight.body.X_WB.p - held_at_[held].p).norm();
  } else if (held >= 0) {
    const bool to_go_back = order.keeps_way && order.body == held && order.grasp_seq != taken_seq_;
    if (!to_go_back) taken_.push_back({held, sight.body.X_WB, way_m_});
    taken_seq_ = order.grasp_seq;
  }
  held_ = held;
  if (held >= 0) held_at_[held] = sight.body.X_WB;
}

}  // namespace tandem
