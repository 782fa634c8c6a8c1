// The page that every picture is drawn on, in pixels.
#pragma once

namespace inbetween {

inline constexpr double page_width = 1400;
/// Of a sheet of paper of that width (A4).
inline constexpr double sheet_height = 1980;
inline constexpr double page_margin = 44;
inline constexpr double content_width = page_width - 2 * page_margin;
inline constexpr double title_height = 66;

}  // namespace inbetween
