// A page to draw on, in pixels from the upper left corner, written as SVG, PNG or PDF by cairo.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace inbetween {

struct Point {
  double x = 0;
  double y = 0;
};

struct Box {
  double x = 0;
  double y = 0;
  double width = 0;
  double height = 0;

  [[nodiscard]] double right() const { return x + width; }
  [[nodiscard]] double bottom() const { return y + height; }
};

/// Red, green, blue and opacity, each 0..1.
struct Color {
  double red = 0;
  double green = 0;
  double blue = 0;
  double opacity = 1;

  [[nodiscard]] constexpr Color faded(double to) const { return {red, green, blue, to}; }
};

struct Stroke {
  Color color{};
  double width = 1;
  bool dashed = false;
};

enum class Align { left, center, right };

struct TextStyle {
  double size = 11;
  Color color{};
  Align align = Align::left;
  bool bold = false;
};

/// Dark: light lines on a dark page, for a screen beside a stage.
enum class PictureStyle { light, dark };

enum class PictureFormat { svg, png, pdf };

/// The format that the ending of the file's name asks for, in upper or lower case.
/// Throws std::runtime_error, one line, for any other ending.
[[nodiscard]] PictureFormat picture_format(const std::filesystem::path& file);

/// One page. Nothing reaches a file before write(): everything is kept in memory until then.
///
/// SVG and PNG count one unit as one pixel. PDF counts 0.75 point (so that the page has the size a browser
/// would print it at), and less where the page would be longer than the 14400 points that PDF viewers accept.
/// The same calls give the same bytes for SVG and PNG; a PDF carries its date of creation.
class Canvas {
 public:
  /// An empty page in the format that the ending of the file's name asks for. Does not touch the file.
  /// Whoever draws gives the colours of the light style. Throws std::runtime_error, one line that starts with
  /// the file's name, for another ending or where the format cannot hold the page (PNG ends at 32767 pixels).
  Canvas(const std::filesystem::path& file, double width, double height,
         PictureStyle style = PictureStyle::light);
  Canvas(Canvas&&) noexcept;
  Canvas& operator=(Canvas&&) noexcept;
  ~Canvas();

  /// A thin line that is exactly horizontal or vertical moves to the middle of its pixels, where it is sharp.
  void line(Point from, Point to, const Stroke& stroke);
  /// Many separate lines as one shape; far smaller in a file than as many calls of line().
  void lines(std::span<const std::pair<Point, Point>> ends, const Stroke& stroke);
  void polyline(std::span<const Point> points, const Stroke& stroke);
  void disc(Point center, double radius, Color fill);
  void ring(Point center, double radius, const Stroke& stroke);
  void outline(const Box& box, const Stroke& stroke);
  void rectangle(const Box& box, Color fill);
  /// Many rectangles as one shape.
  void rectangles(std::span<const Box> boxes, Color fill);
  void polygon(std::span<const Point> corners, Color fill);

  /// UTF-8 text in any script on the base line through `at`, which is its left end, its middle or its right
  /// end.
  void text(Point at, std::string_view words, const TextStyle& style);
  [[nodiscard]] double text_width(std::string_view words, const TextStyle& style);

  /// Ends the page and writes it. `title` and `description` are kept in SVG and PDF for screen readers and
  /// searches (the text of an SVG is drawn as outlines, so that it looks the same where a font is missing).
  /// Throws std::runtime_error, one line that starts with the file's name. Call it once.
  void write(std::string_view title, std::string_view description);

 private:
  struct Page;
  std::unique_ptr<Page> page_;
};

/// The style in which `words` fit into `width`: smaller where they would not.
[[nodiscard]] TextStyle shrunk(Canvas& canvas, std::string_view words, TextStyle style, double width);

/// `words` if they fit into `width`, or else the longest beginning that fits with an ellipsis behind it.
[[nodiscard]] std::string elided(Canvas& canvas, std::string_view words, const TextStyle& style,
                                 double width);

}  // namespace inbetween
