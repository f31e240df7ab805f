#pragma once

#include <string>

#include "app/study/study_file.h"

namespace tandem::testing {

/// Returns a study of three conditions, with a question of each kind.
inline std::string ExampleStudyText() {
  return R"({
    "name": "example", "title": "An example", "seed": 5, "participants": 6,
    "tasks": [{"name": "pull", "scene": "free", "time_limit_s": 4, "hands": ["relaxed"],
               "success": {"moved_mm": 100, "time_s": 3, "peak_force_N": 20, "collisions": 2}}],
    "conditions": [{"name": "near"},
                   {"name": "far", "delay_ms": 300, "jitter_ms": 20, "loss": 0.02,
                    "law": "constant", "gains": {"constant_stiffness": 80}, "gate": false},
                   {"name": "bursty", "burst_enter": 0.01, "burst_leave": 0.1, "burst_loss": 0.9}],
    "blocks": [{"name": "practice", "task": "pull", "conditions": ["near"], "practice": true},
               {"name": "main", "task": "pull", "conditions": ["near", "far", "bursty"],
                "repetitions": 2, "pause_s": 30}],
    "questions": [{"key": "effort", "text": "How hard was it?", "kind": "scale", "low": "easy",
                   "high": "hard"},
                  {"key": "late", "text": "Was it late?", "kind": "choice",
                   "choices": ["yes", "no"]},
                  {"key": "remark", "text": "Anything else?", "kind": "text"}]})";
}

inline Study ExampleStudy() {
  return *ParseStudy(ExampleStudyText(), "example.json");
}

}  // namespace tandem::testing
