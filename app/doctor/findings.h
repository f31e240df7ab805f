#pragma once

#include <array>
#include <cstdint>
#include <string>

#include <nlohmann/json.hpp>

#include "engine/base/text/clean_text.h"

namespace tandem {

enum class Finding : std::uint8_t { kGood, kWarning, kBad };

/// Collects findings, one line each, and what mends them.
class Findings {
 public:
  void Add(Finding verdict, const std::string& what, const std::string& found,
           const std::string& mend = {}) {
    constexpr std::array<const char*, 3> kWords{"ok", "warning", "bad"};
    const char* word = kWords[static_cast<std::size_t>(verdict)];
    json_.push_back({{"check", what}, {"verdict", word}, {"found", found}, {"mend", mend}});
    text_ += std::string(word) + (verdict == Finding::kGood ? "       " : "  ") + CleanText(what) +
             ": " + CleanText(found) + "\n";
    if (!mend.empty()) text_ += "         -> " + CleanText(mend) + "\n";
    bad_ = bad_ || verdict == Finding::kBad;
  }
  const nlohmann::ordered_json& json() const { return json_; }
  const std::string& text() const { return text_; }
  bool bad() const { return bad_; }

 private:
  nlohmann::ordered_json json_ = nlohmann::ordered_json::array();
  std::string text_;
  bool bad_ = false;
};

}  // namespace tandem
