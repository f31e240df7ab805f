#include "tests/app/view/x_mouse.h"

#include <chrono>
#include <cmath>
#include <thread>

// X11 last: it defines common words as macros
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/extensions/XTest.h>

namespace tandem {

namespace {
constexpr int kLeastWindow = 400;  // px; width

/// Goes on after an error: a window may be gone when it is asked about.
int GoOn(::Display*, XErrorEvent*) {
  return 0;
}
}  // namespace

struct XMouse::Display {
  ::Display* x = nullptr;
};

XMouse::XMouse() : display_(std::make_unique<Display>()) {
  XSetErrorHandler(GoOn);
  display_->x = XOpenDisplay(nullptr);
  int a = 0, b = 0, c = 0, d = 0;
  if (display_->x != nullptr && XTestQueryExtension(display_->x, &a, &b, &c, &d) == 0) {
    XCloseDisplay(display_->x);
    display_->x = nullptr;
  }
}

XMouse::~XMouse() {
  if (ready()) XCloseDisplay(display_->x);
}

bool XMouse::ready() const {
  return display_->x != nullptr;
}

void XMouse::MoveTo(const QPoint& at) {
  at_ = at;
  XTestFakeMotionEvent(display_->x, -1, at.x(), at.y(), CurrentTime);
  XFlush(display_->x);
}

void XMouse::DragTo(const QPoint& to, int step_px, int step_ms) {
  const QPoint from = at_;
  const double length = std::hypot(to.x() - from.x(), to.y() - from.y());
  const int steps = std::max(1, static_cast<int>(length / step_px));
  for (int i = 1; i <= steps; ++i) {
    MoveTo(from + (to - from) * (static_cast<double>(i) / steps));
    std::this_thread::sleep_for(std::chrono::milliseconds(step_ms));
  }
}

void XMouse::Press(int button) {
  XTestFakeButtonEvent(display_->x, static_cast<unsigned>(button), 1, CurrentTime);
  XFlush(display_->x);
}

void XMouse::Release(int button) {
  XTestFakeButtonEvent(display_->x, static_cast<unsigned>(button), 0, CurrentTime);
  XFlush(display_->x);
}

void XMouse::Wheel(int notches) {
  const int button = notches > 0 ? 4 : 5;
  for (int i = 0; i < std::abs(notches); ++i) {
    Press(button);
    Release(button);
  }
}

void XMouse::KeyDown(const std::string& key) {
  const KeyCode code = XKeysymToKeycode(display_->x, XStringToKeysym(key.c_str()));
  XTestFakeKeyEvent(display_->x, code, 1, CurrentTime);
  XFlush(display_->x);
}

void XMouse::KeyUp(const std::string& key) {
  const KeyCode code = XKeysymToKeycode(display_->x, XStringToKeysym(key.c_str()));
  XTestFakeKeyEvent(display_->x, code, 0, CurrentTime);
  XFlush(display_->x);
}

void XMouse::Key(const std::string& key) {
  KeyDown(key);
  KeyUp(key);
}

std::vector<unsigned long> XMouse::Windows() const {
  Window root = 0, parent = 0;
  Window* children = nullptr;
  unsigned count = 0;
  std::vector<unsigned long> windows;
  if (XQueryTree(display_->x, DefaultRootWindow(display_->x), &root, &parent, &children, &count) ==
      0) {
    return windows;
  }
  for (unsigned i = 0; i < count; ++i) {
    XWindowAttributes attributes;
    if (XGetWindowAttributes(display_->x, children[i], &attributes) == 0) continue;
    if (attributes.map_state == IsViewable && attributes.width >= kLeastWindow) {
      windows.push_back(children[i]);
    }
  }
  if (children != nullptr) XFree(children);
  return windows;
}

void XMouse::Place(unsigned long window, const QRect& where) {
  XMoveResizeWindow(display_->x, window, where.x(), where.y(), static_cast<unsigned>(where.width()),
                    static_cast<unsigned>(where.height()));
  XFlush(display_->x);
}

void XMouse::Focus(unsigned long window) {
  XSetInputFocus(display_->x, window, RevertToParent, CurrentTime);
  XFlush(display_->x);
}

QImage XMouse::Screen() const {
  const Window root = DefaultRootWindow(display_->x);
  XWindowAttributes attributes;
  XGetWindowAttributes(display_->x, root, &attributes);
  XImage* shot = XGetImage(display_->x, root, 0, 0, static_cast<unsigned>(attributes.width),
                           static_cast<unsigned>(attributes.height), AllPlanes, ZPixmap);
  if (shot == nullptr) return {};
  // 24 bits deep, 32 bits a pixel: as QImage has them
  const QImage image(reinterpret_cast<const uchar*>(shot->data), shot->width, shot->height,
                     shot->bytes_per_line, QImage::Format_RGB32);
  QImage copy = image.copy();
  XDestroyImage(shot);
  return copy;
}

}  // namespace tandem
