#include "app/stability/report_data.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/stability/cell_facts.h"

namespace tandem {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::pair<std::string_view, const char*>, 5> kTitles{
    {{"boundary", "Measured boundary beside the exact one"},
     {"live", "Real time beside virtual time"},
     {"comparison", "Real time beside virtual time"},
     {"type1", "Users with bodies of their own (type 1), by their mirrors"},
     {"claim", "Does delay leave users with bodies of their own at peace?"}}};

std::string TitleOf(const std::string& key) {
  for (const auto& title : kTitles) {
    if (title.first == key) return title.second;
  }
  return key;
}

std::string TextOf(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_integer()) return value.dump();
  if (value.is_number()) return TableNumber(value.get<double>());
  if (value.is_null()) return "-";
  std::string text;
  if (value.is_array()) {
    for (const Json& item : value) text += (text.empty() ? "" : ", ") + TextOf(item);
    return text.empty() ? "none" : text;
  }
  for (const auto& item : value.items()) {
    text += (text.empty() ? "" : ", ") + item.key() + " " + TextOf(item.value());
  }
  return text;
}

bool IsTable(const Json& value) {
  return value.is_array() && !value.empty() && std::ranges::all_of(value, [](const Json& row) {
           return row.is_object();
         });
}

bool IsClaim(const Json& row) {
  return row.is_object() && row.contains("name") && row["name"].is_string() &&
         row.contains("bar") && row.contains("value") && row["value"].is_number() &&
         row.contains("pass") && row["pass"].is_boolean();
}

ReportTable TableOf(const std::string& title, const std::string& note, const Json& rows) {
  ReportTable table{title, note, {}, {}};
  for (const Json& row : rows) {
    for (const auto& item : row.items()) {
      if (std::ranges::find(table.columns, item.key()) == table.columns.end()) {
        table.columns.push_back(item.key());
      }
    }
  }
  for (const Json& row : rows) {
    std::vector<std::string>& texts = table.rows.emplace_back();
    for (const std::string& column : table.columns) {
      texts.push_back(row.contains(column) ? TextOf(row[column]) : "");
    }
  }
  return table;
}

void AddObject(const std::string& name, const Json& object, ReportData& data) {
  std::string note;
  for (const auto& item : object.items()) {
    if (item.value().is_structured()) continue;
    note += (note.empty() ? "" : ", ") + item.key() + " " + TextOf(item.value());
  }
  bool any = false;
  for (const auto& item : object.items()) {
    const Json& value = item.value();
    if (!IsTable(value)) continue;
    any = true;
    if (item.key() == "rows" && std::ranges::all_of(value, IsClaim)) {
      for (const Json& row : value) {
        data.rows.push_back({row["name"].get<std::string>(), TextOf(row["bar"]),
                             row["value"].get<double>(), row["pass"].get<bool>()});
      }
    } else {
      data.tables.push_back(
          TableOf(item.key() == "rows" ? name : TitleOf(item.key()), any ? note : "", value));
    }
  }
  if (!any) data.tables.push_back(TableOf(name, "", Json::array({object})));
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
    ReportSweep& sweep = data.sweeps.emplace_back();
    sweep.summary = Summarize(*results);
    sweep.results = *std::move(results);
    return std::nullopt;
  }
  std::ifstream in(file, std::ios::binary);
  if (!in) return Error{file.string() + ": cannot be read"};
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const Json object = Json::parse(text, nullptr, false);
  if (!object.is_object()) {
    return Error{file.string() +
                 ": holds neither a sweep's results (.jsonl) nor an object of JSON"};
  }
  AddObject(file.stem().string(), object, data);
  return std::nullopt;
}

}  // namespace tandem
