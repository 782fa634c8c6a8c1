#include "host_tools/plot/plot_canvas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "host_tools/plot/drawing_library.hpp"
#include "host_tools/text/output_file.hpp"

namespace inbetween {
namespace {

constexpr double png_longest_side = 32767;
constexpr double pdf_longest_side = 14400;
constexpr double points_per_pixel = 0.75;
constexpr const char* font = "DejaVu Sans";

template <auto destroy>
struct Destroy {
  template <class T>
  void operator()(T* object) const {
    (drawing().*destroy)(object);
  }
};
using Surface = std::unique_ptr<cairo_surface_t, Destroy<&DrawingLibrary::cairo_surface_destroy>>;
using Context = std::unique_ptr<cairo_t, Destroy<&DrawingLibrary::cairo_destroy>>;
using TextLayout = std::unique_ptr<PangoLayout, Destroy<&DrawingLibrary::g_object_unref>>;
using FontDescription =
    std::unique_ptr<PangoFontDescription, Destroy<&DrawingLibrary::pango_font_description_free>>;
using FontOptions =
    std::unique_ptr<cairo_font_options_t, Destroy<&DrawingLibrary::cairo_font_options_destroy>>;

void require(cairo_status_t status, const std::filesystem::path& file) {
  if (status != CAIRO_STATUS_SUCCESS) {
    throw std::runtime_error(fmt::format("{}: error: cannot draw the picture: {}", file.string(),
                                         drawing().cairo_status_to_string(status)));
  }
}

// cairo calls this from C code, through which no exception may pass.
cairo_status_t append(void* bytes, const unsigned char* data, unsigned length) noexcept {
  try {
    static_cast<std::string*>(bytes)->append(data, data + length);
    return CAIRO_STATUS_SUCCESS;
  } catch (...) {
    return CAIRO_STATUS_NO_MEMORY;
  }
}

double pdf_scale(double width, double height) {
  return std::min(points_per_pixel, pdf_longest_side / std::max(width, height));
}

Surface make_surface(const std::filesystem::path& file, double width, double height, std::string& bytes) {
  switch (picture_format(file)) {
    case PictureFormat::svg: {
      Surface surface{drawing().cairo_svg_surface_create_for_stream(append, &bytes, width, height)};
      drawing().cairo_svg_surface_set_document_unit(surface.get(), CAIRO_SVG_UNIT_PX);
      return surface;
    }
    case PictureFormat::pdf: {
      const double scale = pdf_scale(width, height);
      return Surface{
          drawing().cairo_pdf_surface_create_for_stream(append, &bytes, scale * width, scale * height)};
    }
    case PictureFormat::png:
      break;
  }
  if (std::max(width, height) > png_longest_side) {
    throw std::runtime_error(fmt::format(
        "{}: error: the page is {:.0f} x {:.0f} pixels and PNG ends at {:.0f}; write .svg or .pdf instead",
        file.string(), width, height, png_longest_side));
  }
  return Surface{drawing().cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(width),
                                                      static_cast<int>(height))};
}

/// The colour that stands on a dark page for one that is made for a white page: greys change places, the
/// others get lighter.
Color on_dark(Color c) {
  constexpr double darkest = 0.11;
  constexpr double lighter = 0.25;
  const auto [least, most] = std::minmax({c.red, c.green, c.blue});
  const bool is_grey = most - least < 0.05;
  const auto changed = [&](double value) {
    return is_grey ? darkest + (1 - darkest) * (1 - value) : value + lighter * (1 - value);
  };
  return {changed(c.red), changed(c.green), changed(c.blue), c.opacity};
}

double crisp(double at, const Stroke& stroke) {
  return stroke.width <= 1.2 ? std::floor(at) + 0.5 : at;
}

std::string escaped_for_xml(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      default:
        // XML has no way to write the other control characters, so the character that stands for one is
        // shown.
        out += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? "\xEF\xBF\xBD"
                                                                              : std::string(1, c);
    }
  }
  return out;
}

// cairo numbers its surfaces through the life of the process and prints that number, which would make the
// second picture of a process differ from the first. Nothing refers to it.
void remove_surface_number(std::string& svg) {
  constexpr std::string_view beginning = "<g id=\"surface";
  const auto at = svg.find(beginning);
  if (at == std::string::npos) return;
  const auto end = svg.find('>', at);
  svg.erase(at + 2, end - at - 2);
}

void add_description(std::string& svg, std::string_view title, std::string_view description) {
  const auto end = svg.find('>', svg.find("<svg"));
  svg.insert(end + 1, fmt::format("\n<title>{}</title>\n<desc>{}</desc>", escaped_for_xml(title),
                                  escaped_for_xml(description)));
}

}  // namespace

PictureFormat picture_format(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (ending == ".svg") return PictureFormat::svg;
  if (ending == ".png") return PictureFormat::png;
  if (ending == ".pdf") return PictureFormat::pdf;
  throw std::runtime_error(
      fmt::format("{}: the name of a picture ends in .svg, .png or .pdf; {}", file.string(),
                  ending.empty() ? "this one has no ending" : fmt::format("{} is none of them", ending)));
}

struct Canvas::Page {
  std::filesystem::path file;
  PictureFormat format;
  PictureStyle style;
  std::string bytes;  // stays where it is: cairo holds its address
  Surface surface;
  Context context;
  TextLayout layout;

  void color(Color c) {
    if (style == PictureStyle::dark) c = on_dark(c);
    drawing().cairo_set_source_rgba(context.get(), c.red, c.green, c.blue, c.opacity);
  }

  void stroke(const Stroke& stroke) {
    constexpr std::array<double, 2> dashes{4, 3};
    color(stroke.color);
    drawing().cairo_set_line_width(context.get(), stroke.width);
    drawing().cairo_set_dash(context.get(), dashes.data(), stroke.dashed ? 2 : 0, 0);
    drawing().cairo_stroke(context.get());
  }

  void fill(Color fill) {
    color(fill);
    drawing().cairo_fill(context.get());
  }

  /// One line, whatever the words are; fontconfig finds a font for each of their scripts.
  PangoLayoutLine* line_of(std::string_view words, const TextStyle& text) {
    const FontDescription description{drawing().pango_font_description_new()};
    drawing().pango_font_description_set_family_static(description.get(), font);
    drawing().pango_font_description_set_weight(description.get(),
                                                text.bold ? PANGO_WEIGHT_BOLD : PANGO_WEIGHT_NORMAL);
    drawing().pango_font_description_set_absolute_size(description.get(), text.size * PANGO_SCALE);
    drawing().pango_layout_set_font_description(layout.get(), description.get());
    drawing().pango_layout_set_text(layout.get(), words.data(), static_cast<int>(words.size()));
    return drawing().pango_layout_get_line_readonly(layout.get(), 0);
  }

  void trace(std::span<const Point> points) {
    drawing().cairo_new_path(context.get());
    for (const Point p : points) drawing().cairo_line_to(context.get(), p.x, p.y);
  }
};

Canvas::Canvas(const std::filesystem::path& file, double width, double height, PictureStyle style)
    : page_(std::make_unique<Page>(Page{file, picture_format(file), style, {}, nullptr, nullptr, nullptr})) {
  page_->surface = make_surface(file, width, height, page_->bytes);
  require(drawing().cairo_surface_status(page_->surface.get()), file);
  page_->context.reset(drawing().cairo_create(page_->surface.get()));
  cairo_t* context = page_->context.get();
  if (page_->format == PictureFormat::pdf) {
    drawing().cairo_scale(context, pdf_scale(width, height), pdf_scale(width, height));
  }
  // Hinting is off, so that text has the same width and the page the same layout in every format.
  const FontOptions options{drawing().cairo_font_options_create()};
  drawing().cairo_font_options_set_hint_style(options.get(), CAIRO_HINT_STYLE_NONE);
  drawing().cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_OFF);
  drawing().cairo_font_options_set_antialias(options.get(), CAIRO_ANTIALIAS_GRAY);
  page_->layout.reset(drawing().pango_cairo_create_layout(context));
  PangoContext* const text = drawing().pango_layout_get_context(page_->layout.get());
  drawing().pango_cairo_context_set_font_options(text, options.get());
  drawing().pango_context_set_round_glyph_positions(text, FALSE);
  drawing().pango_layout_set_single_paragraph_mode(page_->layout.get(), TRUE);
  drawing().cairo_set_line_join(context, CAIRO_LINE_JOIN_ROUND);
  rectangle({0, 0, width, height}, {1, 1, 1, 1});
  require(drawing().cairo_status(context), file);
}

Canvas::Canvas(Canvas&&) noexcept = default;
Canvas& Canvas::operator=(Canvas&&) noexcept = default;
Canvas::~Canvas() = default;

void Canvas::line(Point from, Point to, const Stroke& stroke) {
  if (from.y == to.y) from.y = to.y = crisp(from.y, stroke);
  if (from.x == to.x) from.x = to.x = crisp(from.x, stroke);
  const std::array<Point, 2> ends{from, to};
  polyline(ends, stroke);
}

void Canvas::lines(std::span<const std::pair<Point, Point>> ends, const Stroke& stroke) {
  drawing().cairo_new_path(page_->context.get());
  for (const auto& [from, to] : ends) {
    drawing().cairo_move_to(page_->context.get(), from.x, from.y);
    drawing().cairo_line_to(page_->context.get(), to.x, to.y);
  }
  page_->stroke(stroke);
}

void Canvas::polyline(std::span<const Point> points, const Stroke& stroke) {
  page_->trace(points);
  page_->stroke(stroke);
}

void Canvas::disc(Point center, double radius, Color fill) {
  drawing().cairo_new_path(page_->context.get());
  drawing().cairo_arc(page_->context.get(), center.x, center.y, radius, 0, 2 * std::numbers::pi);
  page_->fill(fill);
}

void Canvas::ring(Point center, double radius, const Stroke& stroke) {
  drawing().cairo_new_path(page_->context.get());
  drawing().cairo_arc(page_->context.get(), center.x, center.y, radius, 0, 2 * std::numbers::pi);
  drawing().cairo_close_path(page_->context.get());
  page_->stroke(stroke);
}

void Canvas::outline(const Box& box, const Stroke& stroke) {
  drawing().cairo_new_path(page_->context.get());
  const Point from{crisp(box.x, stroke), crisp(box.y, stroke)};
  const Point to{crisp(box.right(), stroke), crisp(box.bottom(), stroke)};
  drawing().cairo_rectangle(page_->context.get(), from.x, from.y, to.x - from.x, to.y - from.y);
  page_->stroke(stroke);
}

void Canvas::rectangle(const Box& box, Color fill) {
  rectangles(std::span(&box, 1), fill);
}

void Canvas::rectangles(std::span<const Box> boxes, Color fill) {
  drawing().cairo_new_path(page_->context.get());
  for (const Box& box : boxes)
    drawing().cairo_rectangle(page_->context.get(), box.x, box.y, box.width, box.height);
  page_->fill(fill);
}

void Canvas::polygon(std::span<const Point> corners, Color fill) {
  page_->trace(corners);
  page_->fill(fill);
}

void Canvas::text(Point at, std::string_view words, const TextStyle& style) {
  if (words.empty()) return;
  const double share = style.align == Align::left ? 0 : style.align == Align::center ? 0.5 : 1;
  const double width = share > 0 ? text_width(words, style) : 0;
  PangoLayoutLine* const line = page_->line_of(words, style);
  page_->color(style.color);
  drawing().cairo_move_to(page_->context.get(), at.x - share * width, at.y);
  drawing().pango_cairo_show_layout_line(page_->context.get(), line);
}

double Canvas::text_width(std::string_view words, const TextStyle& style) {
  PangoRectangle extents{};
  drawing().pango_layout_line_get_extents(page_->line_of(words, style), nullptr, &extents);
  return static_cast<double>(extents.width) / PANGO_SCALE;
}

void Canvas::write(std::string_view title, std::string_view description) {
  Page& page = *page_;
  cairo_surface_t* surface = page.surface.get();
  require(drawing().cairo_status(page.context.get()), page.file);
  if (page.format == PictureFormat::png) {
    require(drawing().cairo_surface_write_to_png_stream(surface, append, &page.bytes), page.file);
  }
  if (page.format == PictureFormat::pdf) {
    drawing().cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_TITLE, std::string(title).c_str());
    drawing().cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_SUBJECT,
                                             std::string(description).c_str());
  }
  drawing().cairo_surface_finish(surface);
  require(drawing().cairo_surface_status(surface), page.file);
  if (page.format == PictureFormat::svg) {
    remove_surface_number(page.bytes);
    add_description(page.bytes, title, description);
  }
  write_output(page.file.string(),
               [&](std::FILE* out) { std::fwrite(page.bytes.data(), 1, page.bytes.size(), out); });
}

TextStyle shrunk(Canvas& canvas, std::string_view words, TextStyle style, double width) {
  const double wanted = canvas.text_width(words, style);
  if (wanted > width) style.size *= width / wanted;
  return style;
}

std::string elided(Canvas& canvas, std::string_view words, const TextStyle& style, double width) {
  if (canvas.text_width(words, style) <= width) return std::string(words);
  std::vector<std::size_t> ends{0};  // where a UTF-8 character ends
  for (std::size_t i = 1; i < words.size(); ++i) {
    if ((static_cast<unsigned char>(words[i]) & 0xC0U) != 0x80U) ends.push_back(i);
  }
  const auto with_ellipsis = [&](std::size_t end) { return std::string(words.substr(0, end)) + "…"; };
  const auto too_long = std::partition_point(ends.begin() + 1, ends.end(), [&](std::size_t end) {
    return canvas.text_width(with_ellipsis(end), style) <= width;
  });
  return with_ellipsis(*(too_long - 1));
}

}  // namespace inbetween
