#include "cli/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace lacuna {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr Seconds kQuiet{2.0};
constexpr std::chrono::milliseconds kPeriod{200};
constexpr std::chrono::seconds kLogPeriod{30};
constexpr int kBarWidth = 24;

ProgressStyle chosen_style = ProgressStyle::terminal;

std::string span_of(double seconds) {
  const long s = std::lround(seconds);
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min", s / 3600, s / 60 % 60);
}

std::size_t terminal_width() {
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace

/// Drawn by a thread of its own: long steps report seldom, and the clock goes on.
struct ProgressLine::State {
  std::mutex mutex;
  std::condition_variable wake;
  bool closing = false, drawn = false;
  std::string stage;
  double done = 0.0;
  Clock::time_point begin = Clock::now(), stage_begin = begin, updated = begin;
  double stage_done = 0.0;  ///< share when the present stage began: a resumed run starts late
  std::thread drawer;

  std::string line() const {
    const int full = static_cast<int>(done * kBarWidth);
    const std::string out = fmt::format("[{}{}] ", std::string(static_cast<std::size_t>(full), '#'),
                                        std::string(static_cast<std::size_t>(kBarWidth - full), '.'));
    return (out + words()).substr(0, terminal_width() - 1);
  }

  std::string words() const {
    const double gained = done - stage_done, spent = Seconds(updated - stage_begin).count();
    // Counted down from the last report on: between reports nothing is known but the clock.
    const double left = spent * (1.0 - done) / std::max(gained, 1e-9) - Seconds(Clock::now() - updated).count();
    std::string out = fmt::format("{:3.0f} %  {}", 100.0 * done, stage);
    out += gained > 1e-6 && done < 1.0 ? fmt::format(", {} left", span_of(std::max(left, 1.0)))
                                       : fmt::format(", {} so far", span_of(Seconds(Clock::now() - begin).count()));
    return out;
  }

  static void write(const std::string& text) {
    if (::write(STDERR_FILENO, text.data(), text.size()) < 0) return;  // a lost terminal loses its progress line only
  }

  void draw() {
    std::unique_lock lock(mutex);
    while (!wake.wait_for(lock, kPeriod, [&] { return closing; })) {
      if (Clock::now() - begin < kQuiet) continue;
      write("\r\x1b[K" + line());
      drawn = true;
    }
    if (drawn) write("\r\x1b[K");
  }

  void log() {
    std::unique_lock lock(mutex);
    while (!wake.wait_for(lock, kLogPeriod, [&] { return closing; })) write("lacuna: " + words() + "\n");
  }
};

void set_progress_style(ProgressStyle style) { chosen_style = style; }

ProgressLine::ProgressLine(const std::string& stage) {
  const ProgressStyle style = chosen_style;
  if (style == ProgressStyle::none || (style == ProgressStyle::terminal && ::isatty(STDERR_FILENO) == 0)) return;
  state_ = std::make_unique<State>();
  state_->stage = stage;
  state_->drawer =
      std::thread([state = state_.get(), style] { style == ProgressStyle::log ? state->log() : state->draw(); });
}

ProgressLine::~ProgressLine() {
  if (!state_) return;
  {
    const std::lock_guard lock(state_->mutex);
    state_->closing = true;
  }
  state_->wake.notify_all();
  state_->drawer.join();
}

void ProgressLine::update(const std::string& stage, double done) {
  if (!state_) return;
  const std::lock_guard lock(state_->mutex);
  done = std::isfinite(done) ? std::clamp(done, 0.0, 1.0) : 0.0;
  const bool first = state_->done == 0.0 && done > 0.0, back = done < state_->done;
  if (first || back) {
    state_->stage_begin = Clock::now();
    state_->stage_done = done;
  }
  state_->stage = stage;
  state_->done = done;
  state_->updated = Clock::now();
}

std::function<void(const Progress&)> ProgressLine::callback() {
  return [this](const Progress& progress) { update(progress.stage, progress.done); };
}

}  // namespace lacuna
