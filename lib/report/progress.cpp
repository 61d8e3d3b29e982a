#include "lib/report/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace lanc {

namespace {

std::string duration(double seconds) {
  const auto s = static_cast<std::int64_t>(seconds + 0.5);
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min", s / 3600, s / 60 % 60);
}

int terminal_width() {
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
}

}  // namespace

Progress::Progress(std::string name, bool quiet)
    : name_(std::move(name)), quiet_(quiet), terminal_(::isatty(STDERR_FILENO) != 0) {
  start(0);
}

Progress::~Progress() { clear(); }

void Progress::start(std::int64_t steps) {
  steps_ = steps;
  done_ = skipped_ = 0;
  begin_ = last_ = Clock::now();
}

void Progress::advance(std::int64_t done, const std::string& what, bool skipped) {
  done_ += done;
  if (skipped) skipped_ += done;
  what_ = what;
  const auto now = Clock::now();
  if (quiet_ || steps_ == 0 || now - last_ < (terminal_ ? std::chrono::milliseconds(100) : std::chrono::seconds(10)))
    return;
  last_ = now;
  draw();
}

void Progress::draw() {
  const double seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
  const double rate = static_cast<double>(done_ - skipped_) / std::max(seconds, 1e-9);
  const double left = rate > 0 ? static_cast<double>(steps_ - done_) / rate : 0;
  const int percent = static_cast<int>(100 * done_ / steps_);
  if (!terminal_) {
    fmt::print(stderr, "{}: {} of {} ({} %), {:.3g} a second, {} left; {}\n", name_, done_, steps_, percent, rate,
               duration(left), what_);
    return;
  }
  const int filled = static_cast<int>(20 * done_ / steps_);
  const std::string line = fmt::format("{} [{:#<{}}{:.<{}}] {:3} %  {:.3g}/s  {} left  {}", name_, "", filled, "",
                                       20 - filled, percent, rate, duration(left), what_);
  fmt::print(stderr, "\r{}\033[K", line.substr(0, terminal_width() - 1));
  std::fflush(stderr);
  drawn_ = true;
}

void Progress::say(const std::string& line) {
  if (quiet_) return;
  clear();
  fmt::print(stderr, "{}\n", line);
}

void Progress::clear() {
  if (drawn_) fmt::print(stderr, "\r\033[K");
  drawn_ = false;
}

}  // namespace lanc
