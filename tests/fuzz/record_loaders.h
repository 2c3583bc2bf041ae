// Of loaders.h: what the program itself wrote, and reads back.
#pragma once

#include <vector>

#include "tests/fuzz/loaders.h"

namespace lacuna::test {

std::vector<Loader> record_loaders();

}  // namespace lacuna::test
