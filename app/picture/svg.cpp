#include "app/picture/svg.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "engine/base/text/markup.h"

namespace tandem {

namespace {

std::string Number(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.2f", value);
  std::string out = text.data();
  out.erase(out.find_last_not_of('0') + 1);
  if (out.back() == '.') out.pop_back();
  return out == "-0" ? "0" : out;
}

std::string Hex(const Rgb& colour) {
  std::array<char, 10> text{};
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", colour.r, colour.g, colour.b);
  return text.data();
}

std::string Attribute(const char* name, const std::string& value) {
  return std::string(" ") + name + "=\"" + value + '"';
}

std::string Attribute(const char* name, double value) {
  return Attribute(name, Number(value));
}

std::string AttributesOf(const Stroke& stroke) {
  std::string out = Attribute("stroke", Hex(stroke.colour));
  if (stroke.width != 1) out += Attribute("stroke-width", stroke.width);
  std::string dashes;
  for (const double dash : stroke.dashes) {
    if (!dashes.empty()) dashes += ' ';
    dashes += Number(dash);
  }
  if (!dashes.empty()) out += Attribute("stroke-dasharray", dashes);
  return out;
}

// returns the element's end, with the hint as its title
std::string End(const char* element, const std::string& hint) {
  if (hint.empty()) return "/>\n";
  return "><title>" + EscapedMarkup(hint) + "</title></" + element + ">\n";
}

std::string PathTo(const char* command, double x, double y) {
  return command + Number(x) + ' ' + Number(y);
}

class Writer {
 public:
  void operator()(const RectangleShape& shape) {
    out_ += "<rect" + Attribute("x", shape.box.x) + Attribute("y", shape.box.y) +
            Attribute("width", shape.box.width) + Attribute("height", shape.box.height) +
            Attribute("fill", shape.fill ? Hex(*shape.fill) : "none");
    if (shape.edge) out_ += AttributesOf(*shape.edge);
    out_ += End("rect", shape.hint);
  }

  void operator()(const PolylineShape& shape) {
    if (shape.points.empty()) return;
    std::string points;
    for (const PicturePoint& point : shape.points) {
      if (!points.empty()) points += ' ';
      points += Number(point.x) + ',' + Number(point.y);
    }
    out_ += "<polyline" + Attribute("points", points) + Attribute("fill", "none") +
            AttributesOf(shape.stroke) + Attribute("stroke-linejoin", "round") + "/>\n";
  }

  void operator()(const MarkerShape& shape) {
    const double half = 0.5 * shape.size;
    if (shape.kind == MarkerKind::kCross) {
      const double x = shape.at.x;
      const double y = shape.at.y;
      out_ +=
          "<path" +
          Attribute("d", PathTo("M", x - half, y - half) + PathTo("L", x + half, y + half) +
                             PathTo("M", x - half, y + half) + PathTo("L", x + half, y - half)) +
          AttributesOf({shape.colour, 1.5, {}}) + End("path", shape.hint);
      return;
    }
    out_ += "<circle" + Attribute("cx", shape.at.x) + Attribute("cy", shape.at.y);
    if (shape.kind == MarkerKind::kDot) {
      out_ += Attribute("r", half) + Attribute("fill", Hex(shape.colour));
    } else {
      out_ += Attribute("r", half - 0.75) + Attribute("fill", "none") +
              AttributesOf({shape.colour, 1.5, {}});
    }
    out_ += End("circle", shape.hint);
  }

  void operator()(const LabelShape& shape) {
    out_ += "<text" + Attribute("x", shape.at.x) + Attribute("y", shape.at.y) +
            Attribute("font-size", shape.size);
    if (shape.anchor == TextAnchor::kMiddle) out_ += Attribute("text-anchor", "middle");
    if (shape.anchor == TextAnchor::kEnd) out_ += Attribute("text-anchor", "end");
    if (shape.bold) out_ += Attribute("font-weight", "bold");
    if (shape.colour != kBlack) out_ += Attribute("fill", Hex(shape.colour));
    if (shape.upwards) {
      out_ += Attribute("transform",
                        "rotate(-90 " + Number(shape.at.x) + ' ' + Number(shape.at.y) + ')');
    }
    out_ += '>' + EscapedMarkup(shape.text) + "</text>\n";
  }

  std::string Take() { return std::move(out_); }

 private:
  std::string out_;
};

}  // namespace

std::string SvgOf(const Picture& picture, SvgPlace place) {
  Writer writer;
  for (const PictureShape& shape : picture.shapes) std::visit(writer, shape);
  const std::string size = Number(picture.width) + ' ' + Number(picture.height);
  std::string out = "<svg";
  if (place == SvgPlace::kFile) out += Attribute("xmlns", "http://www.w3.org/2000/svg");
  out += Attribute("viewBox", "0 0 " + size) + Attribute("width", picture.width) +
         Attribute("height", picture.height) +
         Attribute("font-family", "DejaVu Sans, Verdana, Arial, sans-serif") +
         Attribute("role", "img") + Attribute("aria-label", EscapedMarkup(picture.title)) + ">\n";
  return out + writer.Take() + "</svg>\n";
}

}  // namespace tandem
