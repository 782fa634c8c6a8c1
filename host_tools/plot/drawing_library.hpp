// The functions of cairo and pango. They are loaded when the first picture is drawn: with the forty libraries
// behind them they take longer than most commands, which draw nothing.
#pragma once

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>
#include <pango/pangocairo.h>

namespace inbetween {

#define INBETWEEN_DRAWING_FUNCTIONS(FUNCTION)        \
  FUNCTION(cairo_arc)                                \
  FUNCTION(cairo_close_path)                         \
  FUNCTION(cairo_create)                             \
  FUNCTION(cairo_destroy)                            \
  FUNCTION(cairo_fill)                               \
  FUNCTION(cairo_font_options_create)                \
  FUNCTION(cairo_font_options_destroy)               \
  FUNCTION(cairo_font_options_set_antialias)         \
  FUNCTION(cairo_font_options_set_hint_metrics)      \
  FUNCTION(cairo_font_options_set_hint_style)        \
  FUNCTION(cairo_image_surface_create)               \
  FUNCTION(cairo_line_to)                            \
  FUNCTION(cairo_move_to)                            \
  FUNCTION(cairo_new_path)                           \
  FUNCTION(cairo_pdf_surface_create_for_stream)      \
  FUNCTION(cairo_pdf_surface_set_metadata)           \
  FUNCTION(cairo_rectangle)                          \
  FUNCTION(cairo_scale)                              \
  FUNCTION(cairo_set_dash)                           \
  FUNCTION(cairo_set_line_join)                      \
  FUNCTION(cairo_set_line_width)                     \
  FUNCTION(cairo_set_source_rgba)                    \
  FUNCTION(cairo_status)                             \
  FUNCTION(cairo_status_to_string)                   \
  FUNCTION(cairo_stroke)                             \
  FUNCTION(cairo_surface_destroy)                    \
  FUNCTION(cairo_surface_finish)                     \
  FUNCTION(cairo_surface_status)                     \
  FUNCTION(cairo_surface_write_to_png_stream)        \
  FUNCTION(cairo_svg_surface_create_for_stream)      \
  FUNCTION(cairo_svg_surface_set_document_unit)      \
  FUNCTION(g_object_unref)                           \
  FUNCTION(pango_cairo_context_set_font_options)     \
  FUNCTION(pango_cairo_create_layout)                \
  FUNCTION(pango_cairo_show_layout_line)             \
  FUNCTION(pango_context_set_round_glyph_positions)  \
  FUNCTION(pango_font_description_free)              \
  FUNCTION(pango_font_description_new)               \
  FUNCTION(pango_font_description_set_absolute_size) \
  FUNCTION(pango_font_description_set_family_static) \
  FUNCTION(pango_font_description_set_weight)        \
  FUNCTION(pango_layout_get_context)                 \
  FUNCTION(pango_layout_get_line_readonly)           \
  FUNCTION(pango_layout_line_get_extents)            \
  FUNCTION(pango_layout_set_font_description)        \
  FUNCTION(pango_layout_set_single_paragraph_mode)   \
  FUNCTION(pango_layout_set_text)

/// Each under its own name.
struct DrawingLibrary {
#define INBETWEEN_MEMBER(name) decltype(&::name) name = nullptr;
  INBETWEEN_DRAWING_FUNCTIONS(INBETWEEN_MEMBER)
#undef INBETWEEN_MEMBER
};

/// Loads them once. Throws std::runtime_error, one line, where they are not on the machine.
const DrawingLibrary& drawing();

}  // namespace inbetween
