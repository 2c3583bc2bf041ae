// Text as it comes from users and goes to messages: escaping, numbers, UTF-8.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lacuna {

/// The text with control characters and bytes that are not UTF-8 escaped, cut at `limit` characters; no quotes added.
std::string printable(std::string_view text, std::size_t limit = 200);

/// Offset of the first byte that is not part of valid UTF-8, or npos. NUL counts as invalid.
std::size_t find_invalid_utf8(std::string_view text);

/// A whole text that is one decimal number ("-1.5e3", "+2", ".5"); infinities and NaN are numbers here. Independent of
/// the locale. Too small for a double is 0; too large is infinite.
std::optional<double> parse_number(std::string_view text);

/// Shortest decimal form that reads back to the same bits.
std::string format_number(double value);

/// "a, b or c", at most `limit` names.
std::string one_of(const std::vector<std::string>& names, std::size_t limit = 24);

/// Those of `names` that are most like `name`, nearest first.
std::vector<std::string> near_names(const std::string& name, const std::vector<std::string>& names,
                                    std::size_t most = 5);

}  // namespace lacuna
