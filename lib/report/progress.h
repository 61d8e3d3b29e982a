// Progress on stderr: a bar with rate and time left on a terminal, now and then a plain line elsewhere.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace lanc {

class Progress {
 public:
  /// Writes nothing when quiet.
  Progress(std::string name, bool quiet);
  ~Progress();

  /// Begins a run of so many steps.
  void start(std::int64_t steps);
  /// `done` steps are behind us (skipped ones do not count for the rate); `what` comes next.
  void advance(std::int64_t done, const std::string& what, bool skipped = false);
  /// A line of its own, above the bar.
  void say(const std::string& line);
  /// Takes the bar away.
  void clear();

 private:
  void draw();
  using Clock = std::chrono::steady_clock;
  std::string name_, what_;
  bool quiet_, terminal_, drawn_ = false;
  std::int64_t steps_ = 0, done_ = 0, skipped_ = 0;
  Clock::time_point begin_, last_;
};

}  // namespace lanc
