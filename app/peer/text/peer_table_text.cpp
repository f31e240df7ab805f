#include "app/peer/text/peer_table_text.h"

#include <array>
#include <cstdio>

namespace tandem {

namespace {

/// Returns a number with its unit for a column, or a dash.
std::string Cell(bool known, double value, int decimals, const char* unit) {
  std::array<char, 48> text{};
  if (known) std::snprintf(text.data(), text.size(), "%.*f %s", decimals, value, unit);
  return known ? text.data() : "-";
}

std::string Padded(const std::string& text, std::size_t width) {
  return text.size() < width ? text + std::string(width - text.size(), ' ') : text;
}

constexpr std::size_t kColumnCount = 9;
using TableRow = std::array<std::string, kColumnCount>;

std::string Line(const TableRow& cells) {
  constexpr std::array<std::size_t, kColumnCount> kWidths{16, 9, 9, 9, 9, 8, 9, 9, 0};
  std::string line;
  for (std::size_t i = 0; i < kColumnCount; ++i) line += Padded(cells[i], kWidths[i]) + " ";
  return line.substr(0, line.find_last_not_of(' ') + 1);
}

}  // namespace

std::string AsText(const DropCounts& drops) {
  std::string text;
  for (std::size_t i = 0; i < drops.size(); ++i) {
    if (drops[i] == 0) continue;
    if (!text.empty()) text += ", ";
    text += std::string(NameOf(static_cast<Drop>(i))) + " " + std::to_string(drops[i]);
  }
  return text.empty() ? "none" : text;
}

std::vector<std::string> AsLines(const PeerTable& table, const NameFunction& name) {
  std::vector<std::string> lines;
  lines.push_back(
      Line({"peer", "delay", "coupling", "force", "theirs", "differ", "mirror", "age", "dropped"}));
  for (std::uint32_t i = 0; i < table.count; ++i) {
    const PeerTableRow& row = table.rows[i];
    std::string line =
        Line({name(row.peer), Cell(row.loop_age_s > 0, 1e3 * row.delay_s, 0, "ms"),
              Cell(row.coupled, row.stiffness, 0, "N/m"), Cell(row.coupled, row.link_force, 2, "N"),
              Cell(row.coupled, row.its_link_force, 2, "N"),
              Cell(row.coupled, 1e2 * row.disagreement, 0, "%"),
              Cell(row.mirror_age_s >= 0, 1e3 * row.mirror_lag_m, 1, "mm"),
              Cell(row.mirror_age_s >= 0, 1e3 * row.mirror_age_s, 0, "ms"), AsText(row.drops)});
    if (row.trapped) line += "  TRAPPED: something fixed stands between your two bodies";
    if (const std::string limits = AsText(row.limits); !limits.empty()) line += "  " + limits;
    lines.push_back(line);
  }
  for (const std::string& line : Explain(table.own_limits)) {
    lines.push_back("in the last second, " + line);
  }
  return lines;
}

nlohmann::ordered_json AsJson(const FrameLimits& limits) {
  return {{"travel_limited_share", limits.travel_limited},
          {"over_capacity_share", limits.over_capacity},
          {"contacts_full_share", limits.contacts_full},
          {"waited_share", limits.waited}};
}

nlohmann::ordered_json AsJson(const PeerTable& table, const NameFunction& name) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (std::uint32_t i = 0; i < table.count; ++i) {
    const PeerTableRow& row = table.rows[i];
    nlohmann::ordered_json drops = nlohmann::ordered_json::object();
    for (std::size_t k = 0; k < row.drops.size(); ++k) {
      if (row.drops[k] > 0) drops[NameOf(static_cast<Drop>(k))] = row.drops[k];
    }
    rows.push_back({{"name", name(row.peer)},
                    {"delay_ms", 1e3 * row.delay_s},
                    {"loop_age_ms", 1e3 * row.loop_age_s},
                    {"coupled", row.coupled},
                    {"stiffness_N_per_m", row.stiffness},
                    {"link_force_N", row.link_force},
                    {"its_link_force_N", row.its_link_force},
                    {"disagreement", row.disagreement},
                    {"mirror_lag_mm", 1e3 * row.mirror_lag_m},
                    {"mirror_age_ms", 1e3 * row.mirror_age_s},
                    {"trapped", row.trapped},
                    {"limits", AsJson(row.limits)},
                    {"drops", drops}});
  }
  return rows;
}

}  // namespace tandem
