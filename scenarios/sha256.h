// SHA-256 (FIPS 180-4), by OpenSSL: what seals a label before any diagnosis.
#pragma once

#include <string>
#include <string_view>

namespace lacuna {

/// 64 hexadecimal digits, lower case. Throws WorkError where the library refuses.
std::string sha256(std::string_view bytes);

}  // namespace lacuna
