// The compiled parts of fmt and toml++. Debian has them as shared libraries, which need libstdc++.so in turn;
// the program starts in half of the time without the three of them.
#include <fmt/format-inl.h>

// toml++ asserts that a name begins as a name may, and answers a name that does not with an error behind that
// assertion: "[(" would end the program. Under NDEBUG clang takes each assertion for granted and leaves that
// answer out. So the assertions are nothing here, for every compiler and build, as in Debian's own library.
#undef NDEBUG
#define TOML_ASSERT(condition) static_assert(true)
#define TOML_IMPLEMENTATION
#include <toml++/toml.h>

// What fmt's headers declare, and its own library instantiates, of what is used here.
template fmt::detail::dragonbox::decimal_fp<float> fmt::detail::dragonbox::to_decimal(float) noexcept;
template fmt::detail::dragonbox::decimal_fp<double> fmt::detail::dragonbox::to_decimal(double) noexcept;
template std::locale fmt::detail::locale_ref::get<std::locale>() const;
template fmt::detail::thousands_sep_result<char> fmt::detail::thousands_sep_impl(locale_ref);
template char fmt::detail::decimal_point_impl(locale_ref);
template void fmt::detail::vformat_to(buffer<char>&, string_view, basic_format_args<format_context>,
                                      locale_ref);
