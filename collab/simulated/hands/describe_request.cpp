#include "collab/simulated/hands/describe_request.h"

#include "collab/simulated/checkers/violations.h"

namespace tandem {

namespace {

struct Describing {
  std::string operator()(const GrabRequest& grab) const { return "grab " + grab.body; }
  std::string operator()(const ReleaseRequest&) const { return "release"; }
  std::string operator()(const GiveRequest& give) const { return "give to " + give.peer; }
  std::string operator()(const AskForRequest& ask) const { return "ask for " + ask.body; }
  std::string operator()(const RetraceRequest& back) const {
    using To = RetraceRequest::To;
    return back.to == To::kGrasp  ? "go back to where it was taken"
           : back.to == To::kUndo ? "undo"
                                  : "reset";
  }
  std::string operator()(const SetParameterRequest& set) const {
    return set.name + Text(" = %g", set.value);
  }
  std::string operator()(const EmergencyStopRequest&) const { return "emergency stop"; }
  std::string operator()(const ResumeRequest&) const { return "resume"; }
  template <typename Other>
  std::string operator()(const Other&) const {
    return "something else";
  }
};

}  // namespace

std::string DescribeRequest(const ControlRequest& request) {
  return std::visit(Describing{}, request);
}

}  // namespace tandem
