#include "engine/base/text/json_texts.h"

#include <utility>

#include <nlohmann/json.hpp>

namespace tandem {

namespace {

/// Collects the texts of TextsWithin() from a parser that keeps nothing.
class TextCollector final : public nlohmann::json_sax<nlohmann::json> {
 public:
  TextCollector(std::string_view outer, std::string_view key, std::size_t most)
      : outer_(outer), key_(key), most_(most) {}

  std::vector<std::string> texts;
  std::string fault;  // empty: none

  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool binary(binary_t&) override { return true; }
  bool string(string_t& text) override {
    if (!within_ || !wanted_) return true;
    if (texts.size() == most_) {
      fault = "has more than " + std::to_string(most_) + " values \"" + std::string(key_) + '"';
      return false;
    }
    texts.push_back(text);
    return true;
  }
  bool key(string_t& name) override {
    if (depth_ == 1) within_ = name == outer_;
    wanted_ = name == key_;
    return true;
  }
  bool start_object(std::size_t) override { return Enter(); }
  bool start_array(std::size_t) override { return Enter(); }
  bool end_object() override { return Leave(); }
  bool end_array() override { return Leave(); }
  bool parse_error(std::size_t byte, const std::string& /*word*/,
                   const nlohmann::detail::exception& /*why*/) override {
    fault = "is no JSON from its byte " + std::to_string(byte) + " on";
    return false;
  }

 private:
  bool Enter() {
    ++depth_;
    return true;
  }
  bool Leave() {
    --depth_;
    return true;
  }

  std::string_view outer_;
  std::string_view key_;
  std::size_t most_;
  std::size_t depth_ = 0;
  bool within_ = false;  // the root's value under outer_
  bool wanted_ = false;  // the newest key is key_
};

}  // namespace

Result<std::vector<std::string>> TextsWithin(std::string_view text, std::string_view outer,
                                             std::string_view key, std::size_t most) {
  TextCollector collector(outer, key, most);
  const bool whole = nlohmann::json::sax_parse(text.begin(), text.end(), &collector);
  if (!whole || !collector.fault.empty()) return Error{collector.fault};
  return std::move(collector.texts);
}

}  // namespace tandem
