#pragma once

#include <QImage>
#include <QPoint>
#include <QRect>
#include <memory>
#include <string>
#include <vector>

namespace tandem {

/// Mouse, keys and screen of the X server that DISPLAY names, by its XTEST extension. A program
/// gets what a person's devices would give it.
class XMouse {
 public:
  XMouse();
  ~XMouse();
  bool ready() const;

  void MoveTo(const QPoint& at);
  /// Drags in steps of a few pixels, a few milliseconds each.
  void DragTo(const QPoint& to, int step_px = 4, int step_ms = 8);
  void Press(int button = 1);
  void Release(int button = 1);
  void Wheel(int notches);  // > 0: up
  /// Presses a key by X's name of it: "Escape", "g", "Control_L".
  void KeyDown(const std::string& key);
  void KeyUp(const std::string& key);
  void Key(const std::string& key);
  const QPoint& at() const { return at_; }

  /// Returns windows that are as large as a program's own, the newest last.
  std::vector<unsigned long> Windows() const;
  void Place(unsigned long window, const QRect& where);
  void Focus(unsigned long window);
  QImage Screen() const;

 private:
  struct Display;
  std::unique_ptr<Display> display_;
  QPoint at_;
};

}  // namespace tandem
