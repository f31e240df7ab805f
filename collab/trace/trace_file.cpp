#include "collab/trace/trace_file.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/base/files/regular_file.h"
#include "engine/base/files/whole_file.h"
#include "engine/base/text/json_reader.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

constexpr std::size_t kLongestTraceLine = 4096;  // bytes
constexpr const char* kBothWays = "seq,there_ms,back_ms";
constexpr const char* kOneWay = "seq,there_ms";

std::optional<Error> ReadHeader(const std::string& line, const std::string& name,
                                NetworkTrace& trace) {
  if (line.rfind("# {", 0) != 0) {
    return Error{name + ":1: is no trace: expected a line '# {\"tandem_trace\": 1, ...}'"};
  }
  const Result<JsonFile> json = JsonFile::Parse(line.substr(2), name + ":1");
  if (!json) return json.error();
  const JsonNode root = json->root();
  root.AllowKeys({"tandem_trace", "rate_hz", "source", "clock_bound_ms"});
  root["tandem_trace"].WholeNumber(1, 1);
  trace.rate_hz = root["rate_hz"].NumberBetween(1, kMostTraceHz);
  if (root.Has("source")) trace.source = root["source"].Text("one line");
  if (root.Has("clock_bound_ms")) {
    trace.clock_bound_ms = root["clock_bound_ms"].NumberBetween(0, 1e6);
  }
  return json->fault();
}

/// Returns a cell's delay; nullopt: the cell has none.
std::optional<float> DelayIn(std::string_view cell) {
  if (cell.empty()) return NetworkTrace::kLost;
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc{} || end != cell.data() + cell.size()) return std::nullopt;
  if (!(value >= 0 && value <= kLongestTracedMs)) return std::nullopt;
  return static_cast<float>(value);
}

/// Appends one row to `trace`; returns false if it is malformed.
bool TakeRow(std::string_view line, std::size_t columns, NetworkTrace& trace) {
  std::array<std::string_view, 3> cells;
  for (std::size_t i = 0; i < columns; ++i) {
    const std::size_t comma = line.find(',');
    if ((comma == std::string_view::npos) != (i + 1 == columns)) return false;
    cells[i] = line.substr(0, comma);
    line.remove_prefix(comma == std::string_view::npos ? line.size() : comma + 1);
  }
  std::size_t seq = 0;
  const char* const end = cells[0].data() + cells[0].size();
  const auto [read, error] = std::from_chars(cells[0].data(), end, seq);
  if (error != std::errc{} || read != end || seq != trace.there_ms.size()) return false;
  const std::optional<float> there = DelayIn(cells[1]);
  const std::optional<float> back = columns == 3 ? DelayIn(cells[2]) : there;
  if (!there || !back) return false;
  trace.there_ms.push_back(*there);
  trace.back_ms.push_back(*back);
  return true;
}

}  // namespace

float AsInFile(double delay_ms) {
  return static_cast<float>(std::round(1e3 * delay_ms) / 1e3);
}

Result<NetworkTrace> ReadNetworkTrace(const std::filesystem::path& file) {
  Result<RegularFile> opened = RegularFile::Open(file);
  if (!opened) return opened.error();
  LineReader lines(*std::move(opened), kLongestTraceLine);
  const std::string name = file.string();
  NetworkTrace trace;
  std::string line;
  lines.Next(line);
  if (const auto fault = ReadHeader(line, name, trace)) return *fault;
  line.clear();
  lines.Next(line);
  if (line != kBothWays && line != kOneWay) {
    return Error{name + ":2: expected the columns " + kBothWays + " or " + kOneWay};
  }
  const std::size_t columns = line == kBothWays ? 3 : 2;
  while (lines.Next(line)) {
    const std::string place = name + ":" + std::to_string(trace.there_ms.size() + 3);
    if (trace.there_ms.size() == kMostTraceSamples) {
      return Error{place + ": more than " + std::to_string(kMostTraceSamples) + " samples"};
    }
    if (!TakeRow(line, columns, trace)) {
      return Error{place + ": expected " + std::to_string(trace.there_ms.size()) +
                   " and delays from 0 to " + std::to_string(std::lround(kLongestTracedMs)) +
                   " ms, or nothing between the commas where the sample was lost"};
    }
  }
  if (lines.too_long()) return Error{name + ": has a line too long for a trace"};
  if (trace.there_ms.empty()) return Error{name + ": has no sample"};
  return trace;
}

std::optional<Error> WriteNetworkTrace(const std::filesystem::path& file,
                                       const NetworkTrace& trace) {
  Result<WholeFile> out = WholeFile::Create(file);
  if (!out) return out.error();
  nlohmann::ordered_json header{{"tandem_trace", 1}, {"rate_hz", trace.rate_hz}};
  if (!trace.source.empty()) header["source"] = trace.source;
  if (trace.clock_bound_ms >= 0) header["clock_bound_ms"] = trace.clock_bound_ms;
  out->Write("# " + JsonText(header) + "\n" + kBothWays + "\n");
  for (std::size_t i = 0; i < trace.there_ms.size(); ++i) {
    std::string row = std::to_string(i);
    for (const float delay : {trace.there_ms[i], trace.back_ms[i]}) {
      std::array<char, 32> cell{};
      if (delay >= 0) {
        std::snprintf(cell.data(), cell.size(), "%.3f", static_cast<double>(delay));
      }
      row.append(",").append(cell.data());
    }
    if (!out->Write(row.append("\n"))) break;
  }
  return out->Commit();
}

}  // namespace tandem
