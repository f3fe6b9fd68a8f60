// A small SVG writer: boxes with axes, polylines, polygons, text. Coordinates in pixels, y down.
#pragma once

#include <array>
#include <cstdio>
#include <string>
#include <vector>

namespace omni::tools {

struct SvgPoint {
  double x = 0, y = 0;
};

class Svg {
 public:
  Svg(int width, int height) {
    text_ = Format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" viewBox=\"0 0 %d %d\" "
        "font-family=\"system-ui,sans-serif\" font-size=\"12\">\n",
        width, height, width, height);
    text_ += "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  }

  void Raw(const std::string& element) { text_ += element + "\n"; }

  void Rect(double x, double y, double width, double height, const char* style) {
    text_ += Format("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" %s/>\n", x, y, width, height, style);
  }

  void Circle(double x, double y, double radius, const char* style) {
    text_ += Format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\" %s/>\n", x, y, radius, style);
  }

  void Line(SvgPoint a, SvgPoint b, const char* style) {
    text_ += Format("<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" %s/>\n", a.x, a.y, b.x, b.y, style);
  }

  void Polyline(const std::vector<SvgPoint>& points, const char* style) { Poly("polyline", points, style); }
  void Polygon(const std::vector<SvgPoint>& points, const char* style) { Poly("polygon", points, style); }

  // `content` is escaped.
  void Text(double x, double y, const std::string& content, const char* style = "") {
    text_ += Format("<text x=\"%.1f\" y=\"%.1f\" %s>", x, y, style) + Escape(content) + "</text>\n";
  }

  std::string Finish() const { return text_ + "</svg>\n"; }

 private:
  template <class... Arguments>
  static std::string Format(const char* format, Arguments... arguments) {
    std::array<char, 512> buffer{};
    std::snprintf(buffer.data(), buffer.size(), format, arguments...);
    return buffer.data();
  }

  void Poly(const char* tag, const std::vector<SvgPoint>& points, const char* style) {
    text_ += std::string("<") + tag + " points=\"";
    for (const SvgPoint& p : points) text_ += Format("%.1f,%.1f ", p.x, p.y);
    text_ += std::string("\" ") + style + "/>\n";
  }

  static std::string Escape(const std::string& content) {
    std::string escaped;
    for (const char c : content) {
      if (c == '<') {
        escaped += "&lt;";
      } else if (c == '&') {
        escaped += "&amp;";
      } else {
        escaped += c;
      }
    }
    return escaped;
  }

  std::string text_;
};

}  // namespace omni::tools
