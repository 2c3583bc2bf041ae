// libFuzzer on the loader that the environment names: LACUNA_FUZZ_LOADER=csv fuzz_loader FOLDER...
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/loaders.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const char* const name = std::getenv("LACUNA_FUZZ_LOADER");
  static const lacuna::test::Loader& loader = lacuna::test::loader(name == nullptr ? "" : name);
  const std::string fault = fault_of(loader, std::string(reinterpret_cast<const char*>(data), size));
  if (fault.empty()) return 0;
  std::fprintf(stderr, "%s: %s\n", loader.name.c_str(), fault.c_str());
  std::abort();
}
