#include "collab/lab/sweep/results_file.h"

#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <type_traits>
#include <utility>

#include <nlohmann/json.hpp>

#include "collab/lab/metrics/metrics_table.h"
#include "engine/base/files/regular_file.h"
#include "engine/base/files/whole_file.h"
#include "engine/base/hash.h"
#include "engine/base/text/hex.h"
#include "engine/base/text/json_reader.h"

namespace tandem {

namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr std::size_t kLongestLine = 1 << 20;  // bytes

// returns the number, or NaN for null
double NumberOrNone(const JsonNode& node) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  return node.Compact() == "null" ? kNone : node.Number();
}

OrderedJson MetricsJson(const Metrics& metrics) {
  OrderedJson out = OrderedJson::object();
  for (const MetricField& field : MetricFields()) {
    std::visit(
        [&](auto member) {
          out[std::string(field.name)] = metrics.*member;
        },
        field.member);
  }
  return out;
}

Metrics MetricsOf(const JsonNode& node) {
  Metrics metrics;
  for (const MetricField& field : MetricFields()) {
    std::visit(
        [&](auto member) {
          using Value = std::remove_reference_t<decltype(metrics.*member)>;
          const JsonNode value = node[field.name];
          if constexpr (std::is_same_v<Value, bool>) {
            metrics.*member = value.TrueOrFalse();
          } else if constexpr (std::is_same_v<Value, int>) {
            metrics.*member = value.WholeNumber(0, std::numeric_limits<int>::max());
          } else if constexpr (std::is_integral_v<Value>) {
            metrics.*member =
                static_cast<Value>(value.Unsigned(std::numeric_limits<std::int64_t>::max()));
          } else {
            metrics.*member = NumberOrNone(value);
          }
        },
        field.member);
  }
  return metrics;
}

Verdict VerdictOf(const JsonNode& node) {
  const std::string word = node.Text();
  for (const Verdict verdict : {Verdict::kStable, Verdict::kUnstable, Verdict::kUndecided}) {
    if (word == NameOf(verdict)) return verdict;
  }
  node.Expected("a verdict");
  return Verdict::kUndecided;
}

/// Returns the coverage of a prediction. Results without it cover one axis of free motion or
/// passivity: motion is the nearer.
Prediction::Covers CoverageOf(const JsonNode& predicted) {
  if (!predicted.Has("covers")) return Prediction::Covers::kMotion;
  const std::string word = predicted["covers"].Text();
  for (const auto covers : {Prediction::Covers::kMotion, Prediction::Covers::kPassivity}) {
    if (word == NameOf(covers)) return covers;
  }
  predicted["covers"].Expected("what a prediction covers");
  return Prediction::Covers::kMotion;
}

Expectation ExpectationOf(const JsonNode& node) {
  if (node.Compact() == "null") return Expectation::kNothing;
  const std::string word = node.Text();
  for (const Expectation expect : {Expectation::kStable, Expectation::kUnstable}) {
    if (word == NameOf(expect)) return expect;
  }
  node.Expected("\"stable\", \"unstable\" or null");
  return Expectation::kNothing;
}

ResultsHeader HeaderOf(const JsonNode& node) {
  ResultsHeader header;
  header.sweep = node["sweep"].Text();
  header.seed = static_cast<std::uint64_t>(node["seed"].WholeNumber(0, 1'000'000'000));
  header.sweep_hash = node["sweep_hash"].Text();
  header.version = node["version"].Text();
  header.program = node["program"].Text();
  header.cells =
      static_cast<std::size_t>(node["cells"].WholeNumber(1, static_cast<int>(kMostCells)));
  header.shard = node["shard"].Text();
  header.command = node["command"].Text();
  return header;
}

CellRecord RecordOf(const JsonNode& node) {
  CellRecord record;
  record.cell.number =
      static_cast<std::size_t>(node["cell"].WholeNumber(0, static_cast<int>(kMostCells)));
  record.cell.key = node["key"].Text();
  record.cell.case_json = node["case"].Compact();
  record.cell.expect = ExpectationOf(node["expect"]);
  CellOutcome& outcome = record.outcome;
  outcome.result.verdict = VerdictOf(node["verdict"]);
  if (node["predicted"].Compact() != "null") {
    const double critical = NumberOrNone(node["predicted"]["critical"]);
    outcome.predicted = {node["predicted"]["stiffness"].Number(),
                         std::isnan(critical) ? std::numeric_limits<double>::infinity() : critical,
                         CoverageOf(node["predicted"])};
  }
  outcome.result.metrics = MetricsOf(node["metrics"]);
  const std::optional<std::uint64_t> digest = FromHex(node["digest"].Text());
  if (!digest) node["digest"].Expected("16 hexadecimal digits");
  outcome.result.digest = digest.value_or(0);
  outcome.result.simulated_s = node["simulated_s"].Number();
  outcome.wall_s = node["wall_s"].Number();
  outcome.cpu_s = node["cpu_s"].Number();
  if (node["fault"].Compact() != "null") outcome.result.fault = Error{node["fault"].Text()};
  return record;
}

}  // namespace

std::string LineOf(const ResultsHeader& header) {
  return OrderedJson{
      {"sweep", header.sweep},           {"seed", header.seed},
      {"sweep_hash", header.sweep_hash}, {"version", header.version},
      {"program", header.program},       {"cells", header.cells},
      {"shard", header.shard},           {"command", PlainLine(header.command, 4096)}}
      .dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

std::string LineOf(const CellRecord& record) {
  const CellOutcome& outcome = record.outcome;
  OrderedJson predicted;
  if (outcome.predicted) {
    // an infinite boundary is written as null
    predicted = {{"stable", outcome.predicted->is_stable()},
                 {"stiffness", outcome.predicted->stiffness},
                 {"critical", outcome.predicted->critical},
                 {"covers", NameOf(outcome.predicted->covers)}};
  }
  OrderedJson expect;
  if (record.cell.expect != Expectation::kNothing) expect = NameOf(record.cell.expect);
  OrderedJson fault;
  if (outcome.result.fault) fault = outcome.result.fault->what;
  return OrderedJson{{"cell", record.cell.number},
                     {"key", record.cell.key},
                     {"case", OrderedJson::parse(record.cell.case_json)},
                     {"verdict", NameOf(outcome.result.verdict)},
                     {"predicted", predicted},
                     {"expect", expect},
                     {"metrics", MetricsJson(outcome.result.metrics)},
                     {"digest", Hex(outcome.result.digest)},
                     {"simulated_s", outcome.result.simulated_s},
                     {"wall_s", outcome.wall_s},
                     {"cpu_s", outcome.cpu_s},
                     {"fault", fault}}
      .dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

Result<Results> ReadResults(const std::filesystem::path& file) {
  Result<RegularFile> opened = RegularFile::Open(file);
  if (!opened) return opened.error();
  LineReader lines(*std::move(opened), kLongestLine);
  Results results;
  std::string line;
  for (std::size_t number = 1; lines.Next(line); ++number) {
    if (!lines.ended()) break;  // the last line has no end: it is incomplete
    const std::string place = file.string() + ": line " + std::to_string(number);
    const Result<JsonFile> json = JsonFile::Parse(line, place);
    if (!json) return json.error();
    if (number == 1) {
      results.header = HeaderOf(json->root());
    } else {
      CellRecord record = RecordOf(json->root());
      const std::size_t cell = record.cell.number;
      if (!json->fault() && cell >= results.header.cells) {
        return Error{place + ": the sweep has no cell " + std::to_string(cell)};
      }
      if (!results.records.emplace(cell, std::move(record)).second) {
        return Error{place + ": cell " + std::to_string(cell) + " was there already"};
      }
    }
    if (json->fault()) return *json->fault();
  }
  if (lines.too_long()) {
    return Error{file.string() + ": has a line of more than " + std::to_string(kLongestLine) +
                 " bytes, which no sweep writes"};
  }
  if (results.header.cells == 0) return Error{file.string() + ": holds no results of a sweep"};
  return results;
}

std::optional<Error> WriteResults(const std::filesystem::path& file, const Results& results) {
  Result<WholeFile> out = WholeFile::Create(file);
  if (!out) return out.error();
  out->Write(LineOf(results.header) + '\n');
  for (const auto& [number, record] : results.records) out->Write(LineOf(record) + '\n');
  return out->Commit();
}

Result<Results> Merge(const std::vector<std::filesystem::path>& files) {
  Results merged;
  for (const std::filesystem::path& file : files) {
    Result<Results> part = ReadResults(file);
    if (!part) return part.error();
    part->header.shard = "1/1";
    if (merged.records.empty() && merged.header.cells == 0) merged.header = part->header;
    if (part->header.sweep_hash != merged.header.sweep_hash) {
      return Error{file.string() + ": of another sweep than " + files[0].string()};
    }
    if (part->header.version != merged.header.version ||
        part->header.program != merged.header.program) {
      return Error{file.string() + ": of another build of tandem than " + files[0].string()};
    }
    for (auto& [number, record] : part->records) {
      if (!merged.records.emplace(number, std::move(record)).second) {
        return Error{file.string() + ": cell " + std::to_string(number) +
                     " is in another file too"};
      }
    }
  }
  std::size_t missing = 0;
  std::ostringstream which;
  for (std::size_t number = 0; number < merged.header.cells; ++number) {
    if (merged.records.contains(number)) continue;
    constexpr std::size_t kNamed = 10;
    if (missing < kNamed) which << (missing == 0 ? "" : ", ") << number;
    if (missing++ == kNamed) which << ", ...";
  }
  if (missing > 0) {
    return Error{std::to_string(missing) + " of " + std::to_string(merged.header.cells) +
                 " cells are missing: " + which.str()};
  }
  return merged;
}

Result<ResultsLog> ResultsLog::Open(const std::filesystem::path& file,
                                    const ResultsHeader& header) {
  ResultsLog log;
  log.file_ = file;
  log.results_.header = header;
  std::error_code ignored;
  // a file without a complete first line holds no results
  const bool begun = std::filesystem::exists(file, ignored) && [&file] {
    Result<RegularFile> opened = RegularFile::Open(file);
    if (!opened) return true;  // ReadResults() gives the error
    LineReader lines(*std::move(opened), kLongestLine);
    std::string line;
    return lines.too_long() || (lines.Next(line) && lines.ended());
  }();
  if (begun) {
    Result<Results> before = ReadResults(file);
    if (!before) return before.error();
    if (before->header.program != header.program || before->header.version != header.version) {
      return Error{file.string() +
                   ": was begun by another build of tandem; give another --out, or remove it"};
    }
    ResultsHeader same = before->header;
    same.command = header.command;
    if (same != header) {
      return Error{file.string() + ": holds another sweep or shard (" + before->header.sweep +
                   ", " + before->header.shard + "); give another --out, or remove it"};
    }
    log.results_ = *std::move(before);
  }
  // drop an incomplete line, and store the command of this run
  log.results_.header = header;
  if (std::optional<Error> failed = WriteResults(file, log.results_)) return *failed;
  log.out_.open(file, std::ios::binary | std::ios::app);
  if (!log.out_) return Error{file.string() + ": cannot be written"};
  return log;
}

std::optional<Error> ResultsLog::Add(const CellRecord& record) {
  out_ << LineOf(record) << '\n' << std::flush;
  if (!out_) return Error{file_.string() + ": cannot be written"};
  results_.records.insert_or_assign(record.cell.number, record);
  return std::nullopt;
}

std::optional<Error> ResultsLog::Finish() {
  out_.close();
  return WriteResults(file_, results_);
}

std::string DigestOf(const Results& results) {
  Hash64 hash;
  for (const auto& [number, record] : results.records) {
    hash.Add(static_cast<std::uint64_t>(number));
    hash.Add(record.outcome.result.digest);
  }
  return Hex(hash.value());
}

}  // namespace tandem
