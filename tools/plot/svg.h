// Plots as SVG: logarithmic axes with ticks, curves, marks, boxes, lines and text, all in one style, light or dark by
// the reader's setting and printed in light.
//
// Lengths are px from the upper left corner, y down. The `kind` of a line or a text says how it looks:
//   text: "answer", the result; "made", the source of the figures; "key", of the legend; "boxed", within a box;
//         "xtick", "ytick", "xlabel", "ylabel", of the axes; "row", "column", of a table of boxes
//   line: "grid"; "limit", dashed; "series s0" to "series s3", as the curve of that number has it in the legend
// Text may hold any characters: it is escaped. Thread: [setup]; one draws. Bound: what is drawn. Errors: none but a
// lack of memory. Source: W3C, Scalable Vector Graphics 1.1.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::plot {

struct Point {
  double x{0}, y{0};
};

struct Size {
  double width{0}, height{0};
};

enum class Anchor { kStart, kMiddle, kEnd };  // the part of a text that is at its point

// "0.3", "1000", from a million on "1e+06".
std::string number_text(double value);

// A logarithmic axis of whole decades.
struct LogAxis {
  double low{0}, high{1};                          // exponents of ten at its ends, whole numbers
  double start{0}, end{1};                         // where they are drawn [px]
  std::string label{};                             // the quantity, with its unit
  bool threes{false};                              // ticks at 3, 30, ... too, if it has at most four decades
  std::string (*tick_text)(double){&number_text};  // the words at a tick of this value

  // The exponents of the decades that hold all from `least` to `most`, both above 0; at least one decade.
  void hold(double least, double most);
  // Where a value is drawn; one below the axis at its start.
  double at(double value) const;
  std::vector<double> ticks() const;
};

class Drawing {
 public:
  void line(std::string_view kind, Point from, Point to);
  void text(std::string_view kind, Point at, Anchor anchor, std::string_view words);
  // A text in lines of at most `most` bytes, each 16 px below the one before. Divided at spaces, but not between a
  // number and its unit; a longer word is cut. Returns the y of the line that would come next.
  double paragraph(std::string_view kind, Point at, std::string_view words, std::size_t most);
  // The curve or the mark of a series, 0 to 3.
  void curve(std::size_t series, std::string_view name, const std::vector<Point>& points);
  void mark(std::size_t series, Point centre);
  // A filled rectangle with its upper left corner at `corner`. `fill`: a colour of CSS, light, for dark text.
  void box(Point corner, Size size, std::string_view fill);
  // The grid, the ticks and the labels of a plot within two axes; y may start at the top or at the bottom. They need 30
  // px above the plot and 45 px below.
  void axes(const LogAxis& x, const LogAxis& y);

  // The file. `title`: what the picture says, for those who do not see it.
  std::string svg(std::string_view title, Size size) const;

 private:
  std::string elements_;
};

}  // namespace tactus::plot
