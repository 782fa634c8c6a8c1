// Where the checkout and the build folder are. places.cpp alone is compiled with these paths: ccache compiles
// every other file of the tests once for all checkouts on a machine.
#pragma once

#include <string>
#include <string_view>

namespace inbetween {

/// A file of the checkout: in_checkout("examples/reveal.toml").
[[nodiscard]] std::string in_checkout(std::string_view path);

/// A file of the build folder: in_build("inbetween") is the program under test.
[[nodiscard]] std::string in_build(std::string_view path);

}  // namespace inbetween
