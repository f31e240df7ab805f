#pragma once

#include <string>

namespace tandem {

/// Guards the start of Qt. Qt aborts the program where its platform plugin is missing, or its
/// display refuses it. Instead, the program then prints one line with a remedy and ends with
/// kExitDisplay. What Qt and the libraries of the display print meanwhile is held back until the
/// start has succeeded.
class QtStart {
 public:
  QtStart();
  ~QtStart() { Succeeded(); }
  QtStart(const QtStart&) = delete;
  QtStart& operator=(const QtStart&) = delete;

  /// Ends the guard: Qt has started.
  void Succeeded();

 private:
  bool under_way_ = true;
};

/// Returns the line for a start that failed. `platform`: QT_QPA_PLATFORM, empty: Qt's choice;
/// `display`: DISPLAY; `words`: what Qt and the libraries said.
std::string WhyQtCannotStart(const std::string& platform, const std::string& display,
                             const std::string& words);

}  // namespace tandem
