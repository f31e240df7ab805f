#include "engine/base/text/json_reader.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/base/files/regular_file.h"
#include "engine/base/text/nearest_word.h"

namespace tandem {
namespace {

using Json = nlohmann::json;

constexpr std::uintmax_t kLargest = 64U << 20U;  // greatest size of a file, bytes
constexpr std::size_t kMostValues = 2'000'000;   // each takes up to a hundred bytes of memory
constexpr std::size_t kDeepest = 64;             // depth of nested brackets
constexpr std::size_t kLongestWord = 64;         // longest word that may be a typing error
constexpr std::size_t kLongestPlace = 200;
constexpr std::size_t kLongestText = 65536;

const Json& Value(const void* value) {
  return *static_cast<const Json*>(value);
}

std::string Plain(double number) {
  std::ostringstream text;
  text << number;  // 0, not 0.0
  return text.str();
}

// returns a value as it stands in the file, cut short
std::string Shown(const Json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) {
    const bool flat =
        value.size() <= 4 && std::none_of(value.begin(), value.end(), [](const Json& v) {
          return v.is_structured();
        });
    if (!flat) return "an array of " + std::to_string(value.size());
  }
  std::string shown = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (shown.size() > 60) shown = shown.substr(0, 57) + "...";
  return shown;
}

std::string WithoutPrefix(std::string_view what) {
  // "[json.exception.parse_error.101] parse error at line 2, column 7: syntax error while ..."
  const std::size_t at = what.find("line ");
  if (at != std::string_view::npos) return std::string(what.substr(at));
  const std::size_t end = what.find("] ");
  return std::string(end == std::string_view::npos ? what : what.substr(end + 2));
}

/// Returns the fault of a text on which the parser would take stack or memory without end; empty:
/// none. The text need not be JSON.
std::string FaultOf(std::string_view text) {
  std::size_t depth = 0;
  std::size_t values = 0;
  std::size_t line = 1;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    line += c == '\n' ? 1U : 0U;
    if (quoted) {
      if (c == '\\') ++i;
      quoted = c != '"';
      continue;
    }
    quoted = c == '"';
    if (c == '[' || c == '{') ++depth;
    if ((c == ']' || c == '}') && depth > 0) --depth;
    values += c == ',' || c == '[' || c == '{' ? 1U : 0U;
    if (depth > kDeepest) {
      return "line " + std::to_string(line) + ": more than " + std::to_string(kDeepest) +
             " brackets in one another";
    }
    if (values > kMostValues) {
      return "line " + std::to_string(line) + ": more than " + std::to_string(kMostValues) +
             " values";
    }
  }
  return {};
}

}  // namespace

struct JsonNode::Content {
  std::string file;
  Json root;
  std::optional<Error> fault;
};

JsonNode::JsonNode(std::shared_ptr<Content> content, const void* value, std::string place)
    : content_(std::move(content)), value_(value), place_(std::move(place)) {}

void JsonNode::Fault(const std::string& what) const {
  if (content_->fault) return;
  const std::string place = place_.empty() ? "" : PlainLine(place_, kLongestPlace) + ": ";
  content_->fault = Error{content_->file + ": " + place + PlainLine(what, 2000)};
}

void JsonNode::Expected(std::string_view expected) const {
  Fault("expected " + std::string(expected) + ", got " +
        (value_ == nullptr ? "nothing" : Shown(Value(value_))));
}

bool JsonNode::Has(std::string_view key) const {
  return value_ != nullptr && Value(value_).is_object() && Value(value_).contains(key);
}

JsonNode JsonNode::operator[](std::string_view key) const {
  const std::string place = place_.empty() ? std::string(key) : place_ + "." + std::string(key);
  if (value_ == nullptr || !Value(value_).is_object()) {
    Expected("an object");
    return {content_, nullptr, place};
  }
  const auto found = Value(value_).find(key);
  return {content_, found == Value(value_).end() ? nullptr : &*found, place};
}

std::vector<JsonNode> JsonNode::Items() const {
  std::vector<JsonNode> items;
  if (value_ == nullptr || !Value(value_).is_array()) {
    Expected("an array");
    return items;
  }
  for (const Json& value : Value(value_)) {
    items.push_back({content_, &value, place_ + "[" + std::to_string(items.size()) + "]"});
  }
  return items;
}

bool JsonNode::IsArray() const {
  return value_ != nullptr && Value(value_).is_array();
}

bool JsonNode::IsObject() const {
  return value_ != nullptr && Value(value_).is_object();
}

std::string JsonNode::Compact() const {
  return value_ == nullptr ? "null"
                           : Value(value_).dump(-1, ' ', false, Json::error_handler_t::replace);
}

void JsonNode::AllowKeys(std::initializer_list<std::string_view> keys) const {
  if (value_ == nullptr || !Value(value_).is_object()) {
    Expected("an object");
    return;
  }
  const std::vector<std::string_view> known(keys);
  for (const auto& [key, value] : Value(value_).items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    if (content_->fault) return;
    const std::string_view nearest =
        key.size() > kLongestWord ? std::string_view() : NearestWord(key, known);
    std::string hint = nearest.empty() ? "known here are" : "did you mean";
    if (nearest.empty()) {
      for (const std::string_view word : known) hint += " " + std::string(word);
    } else {
      hint += " " + std::string(nearest) + "?";
    }
    (*this)[key].Fault("unknown key; " + hint);
  }
}

std::string JsonNode::Text(std::string_view expected) const {
  if (value_ != nullptr && Value(value_).is_string()) {
    auto text = Value(value_).get<std::string>();
    if (!text.empty() && text.size() <= kLongestText && IsPlainText(text)) return text;
    if (!text.empty()) {
      Fault(text.size() > kLongestText
                ? "longer than " + std::to_string(kLongestText) + " bytes: shorten it"
                : std::string("has a control character: leave it out"));
      return {};
    }
  }
  Expected(expected);
  return {};
}

std::string JsonNode::PlainText(std::size_t most) const {
  const std::string* text =
      value_ == nullptr ? nullptr : Value(value_).get_ptr<const std::string*>();
  if (text != nullptr && text->size() <= most && IsPlainText(*text)) return *text;
  Expected("plain text of at most " + std::to_string(most) + " bytes");
  return {};
}

bool JsonNode::TrueOrFalse() const {
  if (value_ != nullptr && Value(value_).is_boolean()) return Value(value_).get<bool>();
  Expected("true or false");
  return false;
}

double JsonNode::NumberWhere(bool (*good)(double, double), double limit,
                             const std::string& expected) const {
  if (value_ != nullptr && Value(value_).is_number()) {
    const auto number = Value(value_).get<double>();
    if (std::isfinite(number) && good(number, limit)) return number;
  }
  Expected(expected);
  return limit + 1.0;
}

double JsonNode::Number() const {
  return NumberWhere(
      [](double, double) {
        return true;
      },
      0.0, "a number");
}

double JsonNode::NumberAbove(double limit) const {
  return NumberWhere(
      [](double a, double b) {
        return a > b;
      },
      limit, "a number above " + Plain(limit));
}

double JsonNode::NumberFrom(double least) const {
  return NumberWhere(
      [](double a, double b) {
        return a >= b;
      },
      least, "a number of " + Plain(least) + " or more");
}

double JsonNode::NumberBetween(double least, double most) const {
  if (value_ != nullptr && Value(value_).is_number()) {
    const auto number = Value(value_).get<double>();
    if (number >= least && number <= most) return number;
  }
  Expected("a number from " + Plain(least) + " to " + Plain(most));
  return least;
}

std::uint64_t JsonNode::Unsigned(std::uint64_t most) const {
  if (value_ != nullptr && Value(value_).is_number_unsigned()) {
    const auto number = Value(value_).get<std::uint64_t>();
    if (number <= most) return number;
  }
  Expected("a whole number from 0 to " + std::to_string(most));
  return 0;
}

int JsonNode::WholeNumber(int least, int most) const {
  if (value_ != nullptr && Value(value_).is_number_integer()) {
    const auto number = Value(value_).get<double>();
    if (number >= least && number <= most) return static_cast<int>(number);
  }
  Expected("a whole number from " + std::to_string(least) + " to " + std::to_string(most));
  return least;
}

Vec3 JsonNode::Vector() const {
  constexpr std::string_view kExpected = "three numbers [x, y, z]";
  if (value_ == nullptr || !Value(value_).is_array() || Value(value_).size() != 3) {
    Expected(kExpected);
    return Vec3::Zero();
  }
  const std::vector<JsonNode> items = Items();
  return {items[0].Number(), items[1].Number(), items[2].Number()};
}

Quat JsonNode::Rotation() const {
  constexpr std::string_view kExpected = "a rotation [x, y, z, w] of length 1";
  if (value_ == nullptr || !Value(value_).is_array() || Value(value_).size() != 4) {
    Expected(kExpected);
    return Quat::Identity();
  }
  const std::vector<JsonNode> items = Items();
  const Quat q(items[3].Number(), items[0].Number(), items[1].Number(), items[2].Number());
  if (!(std::abs(q.norm() - 1.0) < 1e-3)) {
    Expected(kExpected);
    return Quat::Identity();
  }
  return q.normalized();
}

JsonFile::JsonFile(std::shared_ptr<JsonNode::Content> content) : content_(std::move(content)) {}

Result<JsonFile> JsonFile::Read(const std::filesystem::path& file) {
  const Result<std::string> text = ReadWholeFile(file, kLargest);
  if (!text) return text.error();
  return Parse(*text, file.string());
}

Result<JsonFile> JsonFile::Parse(const std::string& text, const std::string& name) {
  auto content = std::make_shared<JsonNode::Content>();
  content->file = PlainLine(name);
  if (const std::string fault = FaultOf(text); !fault.empty()) {
    return Error{content->file + ": " + fault + ": this is no file of Tandem's"};
  }

  // nlohmann keeps the last of two equal keys; a person would believe either
  std::vector<std::set<std::string>> keys;
  std::string twice;
  const auto watch = [&](int, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key &&
        !keys.back().insert(parsed.get<std::string>()).second) {
      twice = parsed.get<std::string>();
    }
    return true;
  };
  try {
    content->root = Json::parse(text, watch);
  } catch (const Json::exception& fault) {
    return Error{content->file + ": " + PlainLine(WithoutPrefix(fault.what()))};
  }
  if (!twice.empty())
    return Error{content->file + ": the key \"" + PlainLine(twice, kLongestPlace) +
                 "\" is given twice"};
  return JsonFile(std::move(content));
}

JsonNode JsonFile::root() const {
  return {content_, &content_->root, ""};
}

std::optional<Error> JsonFile::fault() const {
  return content_->fault;
}

}  // namespace tandem
