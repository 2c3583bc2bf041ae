// Finds liblacuna_mpi.so beside our own library, the first time that ranks are asked for.
#include <dlfcn.h>

#include <filesystem>

#include "physics/ranks.h"

namespace lacuna {
namespace {

struct Module {
  RankTransport* (*transport)() = nullptr;
  const char* (*version)() = nullptr;
  std::string reason;  ///< why the others are null
};

/// Never closed: MPI does not survive it.
Module load() {
  Dl_info own{};
  if (::dladdr(reinterpret_cast<const void*>(&ranks_info), &own) == 0) return {nullptr, nullptr, "no own library"};
  const std::filesystem::path file = std::filesystem::path(own.dli_fname).parent_path() / "liblacuna_mpi.so";
  void* module = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) return {nullptr, nullptr, ::dlerror()};
  return {reinterpret_cast<RankTransport* (*)()>(::dlsym(module, "lacuna_mpi_transport")),
          reinterpret_cast<const char* (*)()>(::dlsym(module, "lacuna_mpi_version")), ""};
}

const Module& module() {
  static const Module loaded = load();
  return loaded;
}

}  // namespace

std::unique_ptr<Ranks> join_ranks(const StopFlag& asked) {
  if (module().transport == nullptr)
    throw WorkError("started as one of several ranks, but MPI cannot be loaded: " + module().reason);
  return std::make_unique<Ranks>(std::unique_ptr<RankTransport>(module().transport()), asked);
}

RanksInfo ranks_info() {
  if (module().version == nullptr) return {"", module().reason};
  return {module().version(), ""};
}

}  // namespace lacuna
