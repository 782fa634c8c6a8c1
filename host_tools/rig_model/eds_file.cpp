#include "host_tools/rig_model/eds_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "host_tools/text/ini_sections.hpp"
#include "host_tools/text/text_file.hpp"

namespace inbetween {
namespace {

/// A number of CiA 301. What has no bytes here is none: texts, times, what a maker has defined.
struct EdsType {
  std::size_t bytes = 0;
  bool has_sign = false;
  bool is_real = false;
};

struct NumberedType {
  std::uint64_t number;
  EdsType type;
};
constexpr std::array<NumberedType, 19> number_types{{
    {0x01, {1}},       {0x02, {1, true}}, {0x03, {2, true}}, {0x04, {4, true}},
    {0x05, {1}},       {0x06, {2}},       {0x07, {4}},       {0x08, {4, true, true}},
    {0x10, {3, true}}, {0x16, {3}},       {0x12, {5, true}}, {0x11, {8, true, true}},
    {0x13, {6, true}}, {0x14, {7, true}}, {0x15, {8, true}}, {0x18, {5}},
    {0x19, {6}},       {0x1A, {7}},       {0x1B, {8}},
}};

EdsType type_of(std::uint64_t number) {
  const auto found = std::ranges::find(number_types, number, &NumberedType::number);
  return found == number_types.end() ? EdsType{} : found->type;
}

std::uint64_t low_bits(std::size_t bytes) {
  return bytes >= 8 ? ~std::uint64_t{0} : (std::uint64_t{1} << (8 * bytes)) - 1;
}

/// The objects of one file.
class EdsReader {
 public:
  EdsReader(const IniSections& sections, std::string file_name, int node) : sections_(sections), node_(node) {
    file_.path = std::move(file_name);
  }

  EdsFile read() {
    for (const IniFault& fault : sections_.faults()) warn(fault, "it is passed over");
    for (const IniSection& section : sections_.all()) {
      if (const auto address = section.object()) read_object(section, *address);
    }
    std::ranges::stable_sort(file_.objects, {}, &key_of);
    leave_one_of_each();
    std::ranges::stable_sort(warnings_, {}, &IniFault::line);
    for (const IniFault& fault : warnings_) {
      file_.warnings.push_back(fmt::format("{}:{}: warning: {}", file_.path, fault.line, fault.words));
    }
    return std::move(file_);
  }

  static std::tuple<std::uint16_t, std::uint8_t> key_of(const EdsObject& object) {
    return {object.index, object.sub};
  }

 private:
  void warn(const IniFault& fault, std::string_view outcome) {
    warnings_.push_back({fault.line, fmt::format("{}; {}", fault.words, outcome)});
  }
  void warn(const IniValue& value, const std::string& message, std::string_view outcome) {
    warn(value.fault(message), outcome);
  }

  /// Nobody knows which of two is right.
  void leave_one_of_each() {
    std::vector<EdsObject>& objects = file_.objects;
    for (std::size_t i = 1; i < objects.size();) {
      if (key_of(objects[i]) != key_of(objects[i - 1])) {
        ++i;
        continue;
      }
      const auto [first, second] = std::minmax(objects[i - 1].line, objects[i].line);
      warn(IniFault{second, fmt::format("object {:04X}h:{:X} is in line {} already", objects[i].index,
                                        objects[i].sub, first)},
           of_unknown_value);
      forget(objects[i - 1]);
      objects.erase(objects.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
  static void forget(EdsObject& object) {
    object.value.reset();
    object.bytes.clear();
    object.low.reset();
    object.high.reset();
  }

  void read_object(const IniSection& section, const IniSection::Object& address) {
    constexpr std::uint16_t first_index = 0x1000;
    if (address.index < first_index) {
      return warn(IniFault{section.line(),
                           fmt::format("section {} is no object of a device", in_quotes(section.name()))},
                  "it is passed over");
    }
    constexpr std::uint64_t variable = 7;
    constexpr std::uint64_t array = 8;
    constexpr std::uint64_t record = 9;
    const std::uint64_t kind = whole(section, "objecttype").value_or(variable);
    std::uint64_t compact = address.sub ? 0 : whole(section, "compactsubobj").value_or(0);
    if (compact > 254) {
      warn(*section.find("compactsubobj"), fmt::format("is {}, and an object has at most 254 parts", compact),
           "its parts are unknown until the drive is connected");
      compact = 0;
    }
    if (compact > 0) return read_compact(section, address, compact);
    const bool has_parts = !address.sub && (kind == array || kind == record);
    if (!has_parts) add(section, address.index, address.sub.value_or(0), nullptr);
  }

  /// All parts of an array are alike; a section of its own has the values of those that are not.
  void read_compact(const IniSection& section, const IniSection::Object& address, std::uint64_t parts) {
    file_.objects.push_back({.index = address.index,
                             .size = 1,
                             .can_be_written = false,
                             .value = static_cast<std::uint32_t>(parts),
                             .line = section.line()});
    const IniSection* const values = sections_.find(fmt::format("{:x}value", address.index));
    for (std::uint64_t part = 1; part <= parts; ++part) {
      const IniValue* const own = values == nullptr ? nullptr : values->find(std::to_string(part));
      add(section, address.index, static_cast<std::uint8_t>(part), own);
    }
  }

  void add(const IniSection& section, std::uint16_t index, std::uint8_t sub, const IniValue* own) {
    if (file_.objects.size() >= max_eds_objects) {
      throw InputError({file_.path, section.line(), 0},
                       fmt::format("the device has more than {} objects; leave out what it does not need",
                                   max_eds_objects));
    }
    EdsObject object{.index = index, .sub = sub, .line = section.line()};
    read_access(section, object);
    object.can_be_mapped = can_be_mapped(section);
    const std::optional<std::uint64_t> type_number = whole(section, "datatype");
    if (section.find("datatype") == nullptr) {
      warn(IniFault{section.line(), fmt::format("section {} has no DataType", in_quotes(section.name()))},
           of_unknown_value);
    }
    const EdsType type = type_number ? type_of(*type_number) : EdsType{};
    const IniValue* value = own;
    for (const char* const key : {"parametervalue", "defaultvalue"}) {
      if (value == nullptr) value = section.find(key);
    }
    if (type.bytes == 0) {
      if (value != nullptr) object.bytes.assign(value->text().begin(), value->text().end());
    } else if (type.bytes > 4) {
      const std::uint64_t number = value == nullptr ? 0 : number_in(*value, type).value_or(0);
      for (std::size_t i = 0; i < type.bytes; ++i) {
        object.bytes.push_back(static_cast<std::uint8_t>(number >> (8 * i)));
      }
    } else {
      object.size = static_cast<std::uint8_t>(type.bytes);
      if (value != nullptr) object.value = word_in(*value, type);
      if (!type.has_sign) read_limits(section, type, object);
    }
    for (const IniFault& fault : section.faults()) warn(fault, of_unknown_value);
    if (!section.faults().empty()) forget(object);
    file_.objects.push_back(std::move(object));
  }

  void read_access(const IniSection& section, EdsObject& object) {
    const IniValue* const access = section.find("accesstype");
    if (access == nullptr) return;
    const std::string word = lower_case(access->number_text());
    object.can_be_read = word != "wo";
    object.can_be_written = word != "ro" && word != "const";
    constexpr std::array<std::string_view, 6> words{"ro", "wo", "rw", "rwr", "rww", "const"};
    if (std::ranges::find(words, word) != words.end()) return;
    warn(*access, fmt::format("is {}, and none of {}", in_quotes(access->text()), comma_separated(words)),
         "whether it can be written is unknown until the drive is connected");
  }

  [[nodiscard]] bool can_be_mapped(const IniSection& section) {
    const std::uint64_t flag = whole(section, "pdomapping").value_or(1);
    if (flag > 1) {
      warn(*section.find("pdomapping"), fmt::format("is {}, and neither 0 nor 1", flag),
           "whether it can be mapped is unknown until the drive is connected");
    }
    return flag != 0;
  }

  void read_limits(const IniSection& section, const EdsType& type, EdsObject& object) {
    const auto limit = [&](const char* key, std::optional<std::uint32_t>& number) {
      const IniValue* const value = section.find(key);
      if (value != nullptr) number = word_in(*value, type);
    };
    limit("lowlimit", object.low);
    limit("highlimit", object.high);
    if (!object.low || !object.high || *object.low <= *object.high) return;
    warn(*section.find("lowlimit"), fmt::format("is {}, above HighLimit = {}", *object.low, *object.high),
         "neither is believed");
    object.low.reset();
    object.high.reset();
  }

  /// A number without sign; nothing where the key is missing or is none.
  std::optional<std::uint64_t> whole(const IniSection& section, const char* key) {
    const IniValue* const value = section.find(key);
    if (value == nullptr) return {};
    return number_in(*value, {.bytes = 4});
  }

  /// Of a type of at most four bytes.
  [[nodiscard]] std::optional<std::uint32_t> word_in(const IniValue& value, const EdsType& type) {
    const std::optional<std::uint64_t> number = number_in(value, type);
    if (!number) return {};
    return static_cast<std::uint32_t>(*number);
  }

  /// The bits of a number, which may be a sum with $NODEID; nothing, with a warning, where it is none.
  [[nodiscard]] std::optional<std::uint64_t> number_in(const IniValue& value, const EdsType& type) {
    std::string_view text = value.number_text();
    if (text.empty()) return {};
    const bool has_prefix = text.find("0x") != text.npos || text.find("0X") != text.npos;
    if (type.is_real && !has_prefix) return real_in(value, text, type);
    std::uint64_t sum = 0;
    bool is_negative = false;
    while (true) {
      const std::size_t plus = text.find('+');
      const std::optional<std::uint64_t> term = term_in(value, trimmed(text.substr(0, plus)), is_negative);
      if (!term) return {};
      sum += *term;
      if (plus == text.npos) break;
      text.remove_prefix(plus + 1);
    }
    const std::uint64_t all = low_bits(type.bytes);
    // Some makers extend a negative number to 32 bits, whatever its type.
    const bool is_extended = type.has_sign && sum <= 0xFFFFFFFF && (sum | (all >> 1)) == 0xFFFFFFFF;
    const bool fits =
        is_negative ? type.has_sign && (sum | (all >> 1)) == ~std::uint64_t{0} : sum <= all || is_extended;
    if (fits) return sum & all;
    warn(value,
         fmt::format("is {}, which has no room in {}", in_quotes(value.text()),
                     counted(static_cast<std::int64_t>(type.bytes), "byte")),
         of_unknown_value);
    return {};
  }

  std::optional<std::uint64_t> term_in(const IniValue& value, std::string_view term, bool& is_negative) {
    if (lower_case(term) == "$nodeid") return static_cast<std::uint64_t>(node_);
    const bool has_minus = term.starts_with('-');
    if (has_minus) term.remove_prefix(1);
    int base = 10;
    if (term.starts_with("0x") || term.starts_with("0X")) {
      base = 16;
      term.remove_prefix(2);
    } else if (term.size() > 1 && term.starts_with('0')) {
      base = 8;
    }
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(term.data(), term.data() + term.size(), number, base);
    if (error != std::errc{} || end != term.data() + term.size()) {
      warn(value,
           fmt::format("is {}, and no number such as 12, 0x0C, -1 or $NODEID+0x200", in_quotes(value.text())),
           of_unknown_value);
      return {};
    }
    is_negative = is_negative || (has_minus && number != 0);
    return has_minus ? ~number + 1 : number;
  }

  std::optional<std::uint64_t> real_in(const IniValue& value, std::string_view text, const EdsType& type) {
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    constexpr auto max_float = static_cast<double>(std::numeric_limits<float>::max());
    const double max = type.bytes == 8 ? std::numeric_limits<double>::max() : max_float;
    if (error != std::errc{} || end != text.data() + text.size() || !(std::fabs(number) <= max)) {
      warn(value, fmt::format("is {}, and no number such as 1.5", in_quotes(value.text())), of_unknown_value);
      return {};
    }
    if (type.bytes == 8) return std::bit_cast<std::uint64_t>(number);
    return std::bit_cast<std::uint32_t>(static_cast<float>(number));
  }

  static constexpr std::string_view of_unknown_value = "it is unknown until the drive is connected";
  const IniSections& sections_;
  int node_;
  EdsFile file_;
  std::vector<IniFault> warnings_;
};

}  // namespace

const EdsObject* EdsFile::find(std::uint16_t index, std::uint8_t sub) const {
  const auto key = std::tuple(index, sub);
  const auto found = std::ranges::lower_bound(objects, key, {}, &EdsReader::key_of);
  return found != objects.end() && EdsReader::key_of(*found) == key ? &*found : nullptr;
}

EdsFile parse_eds(std::string_view text, const std::string& file_name, int node) {
  const IniSections sections(text, file_name);
  EdsFile file = EdsReader(sections, file_name, node).read();
  if (file.objects.empty()) {
    throw InputError({file_name, 0, 0},
                     "the file has no object, such as [1000]; it must be an EDS or DCF file (CiA 306)");
  }
  return file;
}

EdsFile read_eds_file(const std::filesystem::path& path, int node) {
  return parse_eds(read_text_file(path), path.string(), node);
}

}  // namespace inbetween
