#include "host_tools/text/json_writer.hpp"

#include <nlohmann/json.hpp>
#include <string>

namespace inbetween {

void JsonWriter::quoted(std::string_view text) {
  append(nlohmann::json(std::string(text)).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace inbetween
