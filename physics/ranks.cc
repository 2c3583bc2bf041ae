#include "physics/ranks.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <new>
#include <numeric>
#include <stdexcept>

namespace lacuna {
namespace {

constexpr int kBadInput = 2, kNotDone = 3;

/// Keys of the meetings that are about no pieces.
constexpr std::uint64_t kIdentities = 1, kAnswer = 2;

/// How long ranks that were asked to stop wait for others that may be gone: mpirun kills after 1 s.
constexpr std::chrono::milliseconds kPatience{400};

/// The failure as exit code and message; false for Interrupted.
bool describe(const std::exception_ptr& failure, std::int32_t& code, std::string& message) {
  try {
    std::rethrow_exception(failure);
  } catch (const Interrupted&) {
    return false;
  } catch (const InputError& error) {
    code = kBadInput, message = error.what();
  } catch (const std::invalid_argument& error) {
    code = kBadInput, message = error.what();
  } catch (const std::bad_alloc&) {
    code = kNotDone, message = "out of memory";
  } catch (const std::exception& error) {
    code = kNotDone, message = error.what();
  }
  return true;
}

}  // namespace

Ranks::Ranks(std::unique_ptr<RankTransport> transport, const StopFlag& asked)
    : transport_(std::move(transport)), asked_(asked) {
  hosts_ = texts(transport_->host());
}

void Ranks::agree_on(const std::string& identity) {
  // First, whether all have come for this.
  share(kIdentities, nullptr, {}, std::vector<std::size_t>(hosts_.size(), 0));
  const std::vector<std::string> all = texts(identity);
  for (std::size_t r = 1; r < all.size(); ++r) {
    if (all[r] != all[0])
      end(kBadInput, fmt::format("ranks that would not compute the same bits: {} is {}; {} is {}", name(0), all[0],
                                 name(r), all[r]));
  }
}

std::string Ranks::name(std::size_t rank) const { return fmt::format("rank {} on {}", rank, hosts_.at(rank)); }

std::vector<std::vector<std::byte>> Ranks::gather(std::span<const std::byte> mine, std::span<const std::size_t> bytes) {
  using Clock = std::chrono::steady_clock;
  Clock::time_point since{};
  const auto patient = [&] {
    if (!asked_) return true;
    if (since == Clock::time_point{}) since = Clock::now();
    return Clock::now() - since < kPatience;
  };
  std::vector<std::byte> all(std::accumulate(bytes.begin(), bytes.end(), std::size_t{0}));
  // Until the meeting is over there is nobody to meet again.
  lost_ = true;
  if (!transport_->gather(mine, bytes, all, patient)) throw Interrupted();
  lost_ = false;
  std::vector<std::vector<std::byte>> out;
  auto at = all.begin();
  for (const std::size_t count : bytes) {
    out.emplace_back(at, at + static_cast<std::ptrdiff_t>(count));
    at += static_cast<std::ptrdiff_t>(count);
  }
  return out;
}

void Ranks::end(int code, const std::string& message) {
  parted_ = true;
  throw RanksParted({code, message});
}

std::vector<std::string> Ranks::texts(const std::string& mine) {
  const std::uint64_t length = mine.size();
  const std::vector<std::size_t> sizes(size(), sizeof length);
  std::vector<std::size_t> lengths;
  for (const auto& part : gather(std::as_bytes(std::span(&length, 1)), sizes)) {
    std::uint64_t theirs = 0;
    std::memcpy(&theirs, part.data(), sizeof theirs);
    lengths.push_back(theirs);
  }
  std::vector<std::string> out;
  for (const auto& part : gather(std::as_bytes(std::span(mine)), lengths))
    out.emplace_back(reinterpret_cast<const char*>(part.data()), part.size());
  return out;
}

std::vector<Ranks::Word> Ranks::words_of_all(const Word& mine) {
  const std::vector<std::size_t> sizes(size(), sizeof mine);
  std::vector<Word> words;
  for (const auto& part : gather(std::as_bytes(std::span(&mine, 1)), sizes))
    std::memcpy(&words.emplace_back(), part.data(), sizeof mine);
  return words;
}

/// Throws what these words mean for everybody.
void Ranks::judge(const std::vector<Word>& words, const std::vector<std::string>& messages) {
  for (std::size_t r = 0; r < words.size(); ++r) {
    if (words[r].kind != Kind::leaving) continue;
    end(words[r].code == 0 ? kNotDone : words[r].code,
        name(r) + ": " + (messages[r].empty() ? "finished before the others" : messages[r]));
  }
  for (const Word& word : words) {
    if (word.kind != Kind::asked_to_stop) continue;
    stop_ = true;
    throw Interrupted();
  }
  for (std::size_t r = 0; r < words.size(); ++r) {
    if (words[r].kind != Kind::failed) continue;
    if (words[r].code == kBadInput) throw std::invalid_argument(messages[r]);
    throw WorkError(messages[r]);
  }
  for (std::size_t r = 1; r < words.size(); ++r) {
    if (words[r].key != words[0].key)
      end(kNotDone, fmt::format("{} was asked for other work than {}: both must read the same scenario, recordings and "
                                "checkpoint, in a folder that they share",
                                name(r), name(0)));
  }
}

std::vector<std::vector<std::byte>> Ranks::share(std::uint64_t key, const std::exception_ptr& failure,
                                                 std::span<const std::byte> mine, std::span<const std::size_t> bytes) {
  if (parted_ || lost_) end(kNotDone, "the ranks have parted");
  Word word{asked_ ? Kind::asked_to_stop : Kind::at_work, 0, key};
  std::string message;
  if (failure && word.kind == Kind::at_work)
    word.kind = describe(failure, word.code, message) ? Kind::failed : Kind::asked_to_stop;
  const std::vector<Word> words = words_of_all(word);
  const bool quiet = std::all_of(words.begin(), words.end(), [](const Word& w) { return w.kind == Kind::at_work; });
  judge(words, quiet ? std::vector<std::string>() : texts(message));
  return gather(mine, bytes);
}

std::vector<std::string> Ranks::share_texts(std::uint64_t key, const std::exception_ptr& failure,
                                            const std::string& mine) {
  const std::uint64_t length = mine.size();
  const auto lengths = share(key, failure, std::as_bytes(std::span(&length, 1)),
                             std::vector<std::size_t>(static_cast<std::size_t>(size()), sizeof length));
  std::vector<std::size_t> bytes;
  for (const std::vector<std::byte>& of_rank : lengths) {
    std::uint64_t count = 0;
    std::memcpy(&count, of_rank.data(), sizeof count);
    bytes.push_back(count);
  }
  std::vector<std::string> out;
  for (const std::vector<std::byte>& text : share(key, nullptr, std::as_bytes(std::span(mine)), bytes))
    out.emplace_back(reinterpret_cast<const char*>(text.data()), text.size());
  return out;
}

bool Ranks::as_first(bool answer) {
  const std::byte mine{answer};
  const std::vector<std::size_t> one(size(), 1);
  return share(kAnswer, nullptr, std::span(&mine, 1), one).front().front() != std::byte{0};
}

Ending Ranks::part(Ending mine) {
  std::vector<Word> words;
  std::vector<std::string> messages;
  try {
    if (!parted_ && !lost_) {
      words = words_of_all({Kind::leaving, mine.code, 0});
      messages = texts(mine.message);
    }
  } catch (const std::runtime_error&) {
    return mine;  // nobody answers
  }
  parted_ = true;
  for (std::size_t r = 0; r < words.size() && mine.code == 0; ++r) {
    if (words[r].kind != Kind::leaving) return {kNotDone, name(r) + ": at work when others had finished"};
    if (words[r].code != 0) mine = {words[r].code, name(r) + ": " + messages[r]};
  }
  return mine;
}

bool Ranks::leave() {
  if (!lost_) transport_->leave();
  return !lost_;
}

bool started_as_rank() {
  constexpr const char* kSigns[] = {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK"};
  return std::any_of(std::begin(kSigns), std::end(kSigns),
                     [](const char* sign) { return std::getenv(sign) != nullptr; });
}

}  // namespace lacuna
