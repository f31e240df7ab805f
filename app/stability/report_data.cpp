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

using OrderedJson = nlohmann::ordered_json;

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

void Add(const std::string& item, std::string& list) {
  if (!list.empty()) list += ", ";
  list += item;
}

std::string TextOf(const OrderedJson& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_integer()) return value.dump();
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

ReportTable TableOf(const std::string& title, const std::string& note, const OrderedJson& rows) {
  ReportTable table{title, note, {}, {}};
  for (const OrderedJson& row : rows) {
    for (const auto& item : row.items()) {
      if (std::ranges::find(table.columns, item.key()) == table.columns.end()) {
        table.columns.push_back(item.key());
      }
    }
  }
  for (const OrderedJson& row : rows) {
    std::vector<std::string>& texts = table.rows.emplace_back();
    for (const std::string& column : table.columns) {
      texts.push_back(row.contains(column) ? TextOf(row[column]) : "");
    }
  }
  return table;
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
    if (item.key() == "rows" && std::ranges::all_of(value, IsClaim)) {
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
  std::ifstream in(file, std::ios::binary);
  if (!in) return Error{file.string() + ": cannot be read"};
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const OrderedJson object = OrderedJson::parse(text, nullptr, false);
  if (!object.is_object()) {
    return Error{file.string() +
                 ": holds neither a sweep's results (.jsonl) nor an object of JSON"};
  }
  AddObject(file.stem().string(), object, data);
  return std::nullopt;
}

}  // namespace tandem
