#include "app/stability/report/report_data.h"

#include <algorithm>
#include <array>
#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/stability/report/boundary_picture.h"
#include "app/stability/report/cell_facts.h"
#include "engine/base/files/regular_file.h"
#include "engine/base/text/json_reader.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr std::size_t kMostColumns = 100;  // columns of a table
constexpr std::size_t kMostRows = 10'000;
constexpr double kLongestBoundaryDelay = 1e6;  // s

constexpr std::array<std::pair<std::string_view, const char*>, 5> kTitles{
    {{"boundary", "Measured boundary compared with the exact one"},
     {"live", "Real time compared with virtual time"},
     {"comparison", "Real time compared with virtual time"},
     {"type1", "Users with bodies of their own (type 1), by their mirrors"},
     {"claim", "Do users with bodies of their own come to rest under delay?"}}};

std::string TitleOf(const std::string& key) {
  for (const auto& title : kTitles) {
    if (title.first == key) return title.second;
  }
  return key;
}

void Add(const std::string& item, std::string& list) {
  if (!list.empty()) list += ", ";
  list += item;
}

std::string TextOf(const OrderedJson& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_integer()) return JsonText(value);
  if (value.is_number()) return TableNumber(value.get<double>());
  if (value.is_null()) return "-";
  std::string text;
  if (value.is_array()) {
    for (const OrderedJson& item : value) Add(TextOf(item), text);
    return text.empty() ? "none" : text;
  }
  for (const auto& item : value.items()) {
    Add(item.key() + " " + TextOf(item.value()), text);
  }
  return text;
}

bool IsTable(const OrderedJson& value) {
  return value.is_array() && !value.empty() &&
         std::ranges::all_of(value, [](const OrderedJson& row) {
           return row.is_object();
         });
}

bool IsClaim(const OrderedJson& row) {
  return row.is_object() && row.contains("name") && row["name"].is_string() &&
         row.contains("bar") && row.contains("value") && row["value"].is_number() &&
         row.contains("pass") && row["pass"].is_boolean();
}

// Takes only the first rows and columns: a table has a cell for each pair, and a file may have
// many.
ReportTable TableOf(const std::string& title, const std::string& note, const OrderedJson& rows) {
  ReportTable table{title, note, {}, {}};
  std::set<std::string> columns;
  for (const OrderedJson& row : rows) {
    for (const auto& item : row.items()) {
      if (columns.insert(item.key()).second && table.columns.size() < kMostColumns) {
        table.columns.push_back(item.key());
      }
    }
  }
  std::string left_out;
  if (columns.size() > kMostColumns) {
    Add("columns " + std::to_string(columns.size() - kMostColumns), left_out);
  }
  if (rows.size() > kMostRows) {
    Add("rows " + std::to_string(rows.size() - kMostRows), left_out);
  }
  if (!left_out.empty()) Add("not shown here: " + left_out, table.note);
  for (const OrderedJson& row : rows) {
    if (table.rows.size() == kMostRows) break;
    std::vector<std::string>& texts = table.rows.emplace_back();
    for (const std::string& column : table.columns) {
      texts.push_back(row.contains(column) ? TextOf(row[column]) : "");
    }
  }
  return table;
}

std::string NumberOr(const OrderedJson& row, const char* key, const char* otherwise) {
  const bool there = row.contains(key) && row[key].is_number();
  return there ? TableNumber(row[key].get<double>()) : otherwise;
}

bool IsBoundary(const OrderedJson& row) {
  const auto number = [&row](const char* key) {
    return row.contains(key) && row[key].is_number();
  };
  // delays are above 0, since the picture's axis is logarithmic
  const double delay_s = number("delay_s") ? row["delay_s"].get<double>() : 0;
  return delay_s > 0 && delay_s < kLongestBoundaryDelay && number("predicted_N_m") &&
         row.contains("hand") && row["hand"].is_string();
}

/// Adds the result of `tandem stability boundary`: a table in words, and a picture.
void AddBoundary(const OrderedJson& rows, ReportData& data) {
  ReportTable table{TitleOf("boundary"),
                    "Stiffness of all links of a user together. The bar applies only to two users "
                    "with constant gains and free hands.",
                    {"hand", "one-way delay, ms", "law", "users", "network", "seed", "exact, N/m",
                     "measured, N/m", "measured / exact", "onset, Hz", "runs", "bar", "holds"},
                    {}};
  std::vector<BoundaryMark> marks;
  for (const OrderedJson& row : rows) {
    const auto text = [&row](const char* key, const char* otherwise) {
      return row.contains(key) ? TextOf(row[key]) : std::string(otherwise);
    };
    const double delay_s = row["delay_s"].get<double>();
    const bool judged = row.value("judged", false);
    const bool found = row.contains("measured_N_m") && row["measured_N_m"].is_number();
    const std::string fault = text("fault", "");
    const std::string network = text("network", "clean");
    table.rows.push_back(
        {text("hand", ""), TableNumber(1e3 * delay_s), text("law", ""), text("users", ""), network,
         text("seed", "1"), NumberOr(row, "predicted_N_m", "-"),
         !fault.empty() ? fault : NumberOr(row, "measured_N_m", "none up to 4 times that"),
         NumberOr(row, "ratio", "-"), NumberOr(row, "onset_hz", "-"), text("runs", ""),
         !judged ? "none" : (delay_s < 0.1 ? ">= 0.95" : "0.95 to 1.25"),
         judged ? text("pass", "-") : "-"});
    BoundaryMark& mark = marks.emplace_back();
    mark.kind = "hands " + text("hand", "") + ", " + text("law", "") + ", " + text("users", "2") +
                " users" + (network == "clean" ? "" : ", " + network);
    mark.delay_s = delay_s;
    mark.exact = row["predicted_N_m"].get<double>();
    mark.measured =
        found ? row["measured_N_m"].get<double>() : std::numeric_limits<double>::infinity();
    ++data.searches;
  }
  data.tables.push_back(std::move(table));
  std::string name = "boundary";
  if (!data.pictures.empty()) name += "-" + std::to_string(data.pictures.size() + 1);
  data.pictures.push_back(BoundaryPictureOf(marks, name));
}

void AddObject(const std::string& name, const OrderedJson& object, ReportData& data) {
  std::string note;
  for (const auto& item : object.items()) {
    if (item.value().is_structured()) continue;
    Add(item.key() + " " + TextOf(item.value()), note);
  }
  bool any = false;
  for (const auto& item : object.items()) {
    const OrderedJson& value = item.value();
    if (!IsTable(value)) continue;
    any = true;
    if (item.key() == "boundary" && std::ranges::all_of(value, IsBoundary)) {
      AddBoundary(value, data);
    } else if (item.key() == "rows" && std::ranges::all_of(value, IsClaim)) {
      for (const OrderedJson& row : value) {
        data.rows.push_back({row["name"].get<std::string>(), TextOf(row["bar"]),
                             row["value"].get<double>(), row["pass"].get<bool>()});
      }
    } else {
      data.tables.push_back(
          TableOf(item.key() == "rows" ? name : TitleOf(item.key()), any ? note : "", value));
    }
  }
  if (!any) data.tables.push_back(TableOf(name, "", OrderedJson::array({object})));
}

std::string PlainName(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    out += plain ? c : '-';
  }
  return out.empty() ? "sweep" : out;
}

std::string NameFor(const std::string& sweep, const std::vector<ReportSweep>& others) {
  const std::string plain = PlainName(sweep);
  std::string name = plain;
  for (int number = 2; std::ranges::find(others, name, &ReportSweep::name) != others.end();) {
    name = plain + "-" + std::to_string(number++);
  }
  return name;
}

bool IsJsonl(const std::filesystem::path& file) {
  return file.extension() == ".jsonl";
}

}  // namespace

std::vector<SweepRow> ReportData::AllRows() const {
  std::vector<SweepRow> all;
  for (const ReportSweep& sweep : sweeps) {
    for (SweepRow row : sweep.summary.rows) {
      if (sweeps.size() > 1) row.name = sweep.results.header.sweep + ": " + row.name;
      all.push_back(std::move(row));
    }
  }
  all.insert(all.end(), rows.begin(), rows.end());
  const auto comparable = std::ranges::count_if(series, &ReportSeries::same_build);
  if (comparable > 0) {
    const auto same = std::ranges::count_if(series, [](const ReportSeries& one) {
      return one.same_build && one.same;
    });
    all.push_back({"cells run again with the same digest", "= " + std::to_string(comparable),
                   static_cast<double>(same), same == comparable});
  }
  return all;
}

std::size_t ReportData::cells() const {
  std::size_t count = 0;
  for (const ReportSweep& sweep : sweeps) count += sweep.results.records.size();
  return count;
}

std::optional<Error> AddFile(const std::filesystem::path& file, ReportData& data) {
  const bool is_folder = std::filesystem::is_directory(file);
  if (is_folder || IsJsonl(file)) {
    Result<Results> results = ReadResults(is_folder ? file / "cells.jsonl" : file);
    if (!results) return results.error();
    const std::string name = NameFor(results->header.sweep, data.sweeps);
    ReportSweep& sweep = data.sweeps.emplace_back();
    sweep.name = name;
    sweep.summary = Summarize(*results);
    sweep.results = *std::move(results);
    return std::nullopt;
  }
  constexpr std::uintmax_t kLargest = 64U << 20U;
  const Result<std::string> text = ReadWholeFile(file, kLargest);
  if (!text) return text.error();
  // JsonFile checks brackets and counts values first
  if (const auto sound = JsonFile::Parse(*text, file.string()); !sound) return sound.error();
  const OrderedJson object = OrderedJson::parse(*text, nullptr, false);
  if (!object.is_object()) {
    return Error{file.string() + ": is neither a sweep's results (.jsonl) nor a JSON object"};
  }
  AddObject(file.stem().string(), object, data);
  return std::nullopt;
}

}  // namespace tandem
