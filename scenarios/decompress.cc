#include "scenarios/decompress.h"

#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

#include "scenarios/cdr.h"

namespace lacuna {
namespace {

constexpr std::size_t kFirstBlock = std::size_t{1} << 16;
constexpr std::size_t kUnknownSize = std::string::npos;

/// Calls `step(out, out_size, in, in_size)` until the input is used up. A step says how much of either it used, and
/// whether it stands between two frames.
struct Step {
  std::size_t written = 0, read = 0;
  bool between = false;
};

template <typename F>
std::string unpack(std::string_view bytes, std::size_t size, std::size_t most, const char* form, const F& step) {
  const std::size_t limit = size == kUnknownSize ? most : size;
  if (limit > most)
    throw MessageFault(fmt::format("{} bytes packed in {}", limit, form), fmt::format("at most {}", most));
  std::string out;
  bool between = true;
  while (true) {
    const std::size_t done = out.size();
    // One byte more than there may be: what is too much shows.
    out.resize(std::min(limit + 1, std::max(2 * done, kFirstBlock)));
    const Step made = step(out.data() + done, out.size() - done, bytes.data(), bytes.size());
    out.resize(done + made.written);
    bytes.remove_prefix(made.read);
    if (made.read > 0 || made.written > 0) between = made.between;
    if (out.size() > limit)
      throw MessageFault(fmt::format("more than {} bytes unpacked from {}", limit, form), "as many as are stated");
    if (bytes.empty() && between) break;
    if (made.read == 0 && made.written == 0)
      throw MessageFault("a block of " + std::string(form) + " cut short", "a whole one");
  }
  if (size != kUnknownSize && out.size() != size)
    throw MessageFault(fmt::format("{} bytes unpacked from {}", out.size(), form), fmt::format("{}", size));
  return out;
}

}  // namespace

std::string unpack_zstd(std::string_view bytes, std::size_t size, std::size_t most) {
  const std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  if (!context) throw std::bad_alloc();
  return unpack(bytes, size, most, "zstd", [&](char* out, std::size_t room, const char* in, std::size_t left) {
    ZSTD_outBuffer to{out, room, 0};
    ZSTD_inBuffer from{in, left, 0};
    const std::size_t state = ZSTD_decompressStream(context.get(), &to, &from);
    if (ZSTD_isError(state) != 0)
      throw MessageFault(fmt::format("a block of zstd that does not unpack ({})", ZSTD_getErrorName(state)),
                         "an intact one");
    return Step{to.pos, from.pos, state == 0};
  });
}

std::string unpack_lz4(std::string_view bytes, std::size_t size, std::size_t most) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION)) != 0) throw std::bad_alloc();
  const std::unique_ptr<LZ4F_dctx, LZ4F_errorCode_t (*)(LZ4F_dctx*)> context(made, &LZ4F_freeDecompressionContext);
  return unpack(bytes, size, most, "lz4", [&](char* out, std::size_t room, const char* in, std::size_t left) {
    std::size_t written = room, read = left;
    const std::size_t state = LZ4F_decompress(context.get(), out, &written, in, &read, nullptr);
    if (LZ4F_isError(state) != 0)
      throw MessageFault(fmt::format("a block of lz4 that does not unpack ({})", LZ4F_getErrorName(state)),
                         "an intact one");
    return Step{written, read, state == 0};
  });
}

}  // namespace lacuna
