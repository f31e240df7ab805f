#include <array>
#include <cstdio>

#include "collab/session/messages.h"

namespace tandem {
namespace {

std::string Named(const std::string& gains) {
  return gains.empty() ? "the law's own gains" : gains;
}

std::string Millimetres(double metres) {
  std::array<char, 32> number{};
  std::snprintf(number.data(), number.size(), "%g mm", 1e3 * metres);
  return number.data();
}

std::string Layer(std::int32_t layer) {
  return layer < 0 ? "the scene's" : std::to_string(layer);
}

// Joins phrases with commas.
class List {
 public:
  void Add(const std::string& what) { text_ += (text_.empty() ? "" : ", ") + what; }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace

std::string Describe(const ForceTerms& terms) {
  List list;
  list.Add("law " + terms.law);
  if (!terms.gains.empty()) list.Add(terms.gains);
  if (!terms.gate) list.Add("no energy gate");
  if (!terms.contact) list.Add("no contact");
  if (terms.force_layer >= 0) list.Add("force layer " + Layer(terms.force_layer));
  if (terms.displacement != 0) list.Add("points displaced by " + Millimetres(terms.displacement));
  return list.text();
}

std::string TermsDifference(const ForceTerms& ours, const ForceTerms& theirs) {
  List list;
  if (theirs.law != ours.law) list.Add("law " + theirs.law + " (here " + ours.law + ")");
  if (theirs.gains != ours.gains) {
    list.Add(Named(theirs.gains) + " (here " + Named(ours.gains) + ")");
  }
  if (theirs.gate != ours.gate) {
    list.Add(theirs.gate ? "energy gate (here none)" : "no energy gate (here one)");
  }
  if (theirs.contact != ours.contact) {
    list.Add(theirs.contact ? "contact (here none)" : "no contact (here contact)");
  }
  if (theirs.force_layer != ours.force_layer) {
    list.Add("force layer " + Layer(theirs.force_layer) + " (here " + Layer(ours.force_layer) +
             ")");
  }
  if (theirs.displacement != ours.displacement) {
    list.Add("points displaced by " + Millimetres(theirs.displacement) + " (here " +
             Millimetres(ours.displacement) + ")");
  }
  return list.text();
}

}  // namespace tandem
