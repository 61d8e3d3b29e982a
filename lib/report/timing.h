// Times of calls that are shorter than a clock's reading: repeated until they are long, and divided.
#pragma once

#include <ctime>

namespace lanc {

/// Seconds of processor time this thread has used: other programs on the machine do not count.
inline double thread_seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// How often a call has to be repeated; keeps what it learnt for the next time the same call is measured.
class Repeat {
 public:
  /// Seconds a call, over as many calls as take `at_least` together. The first time, calls until then warm up.
  template <class Call>
  double seconds(Call&& call, double at_least = 200e-6) {
    for (;;) {
      const double begin = thread_seconds();
      for (long i = 0; i < times_; ++i) call();
      const double elapsed = thread_seconds() - begin;
      // Half of it will do for later repetitions, so that the count does not creep upward with every disturbance.
      if (elapsed >= at_least || (settled_ && elapsed >= at_least / 2)) {
        settled_ = true;
        return elapsed / static_cast<double>(times_);
      }
      times_ = elapsed > at_least / 100 ? static_cast<long>(static_cast<double>(times_) * at_least / elapsed * 1.2) + 1
                                        : times_ * 10;
    }
  }

 private:
  long times_ = 1;
  bool settled_ = false;
};

}  // namespace lanc
